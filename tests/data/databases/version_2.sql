-- A database as version 2 of the schema had it: some samples of each kernel of a run of `assur tune`.
PRAGMA application_id = 1098085234;
BEGIN TRANSACTION;
CREATE TABLE fit (                   -- the model as the runtime reads it in place of all samples; can be made anew
  machine INTEGER PRIMARY KEY REFERENCES machine ON DELETE CASCADE,
  content BLOB NOT NULL,             -- PerformanceModel::bytes(), of the build that the libraries are of, and a
                                     -- checksum over the rest of the file: where it differs the samples are read
  checksum INTEGER NOT NULL          -- over the content; one that differs is not believed
) STRICT;
CREATE TABLE library (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,                -- of a backend, or 'assur' for what is no solver's
  version TEXT NOT NULL,             -- 'OpenBLAS 0.3.21, OpenMP, SkylakeX'; own code: with that of assur
  build TEXT NOT NULL,               -- compiler and kind of build: 'GNU 12.2.0 Release'
  UNIQUE (name, version, build)
) STRICT;
INSERT INTO library VALUES(1,'eigen','3.4.0, assur 0.1.0','GNU 12.2.0 Release');
INSERT INTO library VALUES(2,'assur','1.0.3 AVX3, assur 0.1.0','GNU 12.2.0 Release');
INSERT INTO library VALUES(3,'lanes','1.0.3 AVX3, assur 0.1.0','GNU 12.2.0 Release');
INSERT INTO library VALUES(4,'lapack','OpenBLAS 0.3.21, OpenMP, Haswell','GNU 12.2.0 Release');
INSERT INTO library VALUES(5,'team','OpenBLAS 0.3.21, OpenMP, Haswell, assur 0.1.0','GNU 12.2.0 Release');
INSERT INTO library VALUES(7,'mumps','5.5.1','GNU 12.2.0 Release');
CREATE TABLE machine (
  id INTEGER PRIMARY KEY,
  fingerprint TEXT NOT NULL UNIQUE,  -- 16 hexadecimal digits over the columns from vendor to numa_nodes
  vendor TEXT NOT NULL,              -- of the processor, as it calls itself; '' and -1 where it does not
  family INTEGER NOT NULL,
  model INTEGER NOT NULL,
  stepping INTEGER NOT NULL,
  name TEXT NOT NULL,
  instructions TEXT NOT NULL,        -- widest set that assur has code for: 'AVX2', 'AVX3', ...
  cores INTEGER NOT NULL,            -- physical ones that the affinity mask allowed
  processors INTEGER NOT NULL,       -- logical ones: more than cores where a core runs two threads
  quota REAL NOT NULL,               -- processors' time that control groups allowed; 0: no limit
  caches TEXT NOT NULL,              -- of the first core: level:bytes:cores that share it, with blanks between
  numa_nodes INTEGER NOT NULL,
  memory INTEGER NOT NULL            -- bytes when it was first seen; not in the fingerprint
) STRICT;
INSERT INTO machine VALUES(1,'0ff9234809e7e75b','AuthenticAMD',26,2,1,'AMD EPYC','AVX3',2,2,0.0,'1:49152:1 2:1048576:1 3:33554432:2',1,25276510208);
CREATE TABLE model (                 -- what was learned from the samples; can be made anew from them
  machine INTEGER NOT NULL REFERENCES machine ON DELETE CASCADE,
  name TEXT NOT NULL,
  made TEXT NOT NULL,                -- UTC
  assur TEXT NOT NULL,               -- version that made it
  content TEXT NOT NULL,             -- JSON: what was fitted, regret on samples held out
  PRIMARY KEY (machine, name)
) STRICT;
INSERT INTO model VALUES(1,'quick','2026-11-23T16:11:36Z','0.1.0','{}');
CREATE TABLE sample (
  id INTEGER PRIMARY KEY,
  uid TEXT NOT NULL UNIQUE,          -- 32 hexadecimal digits, drawn at random: the same sample in two databases is one
  run INTEGER NOT NULL REFERENCES tuning_run ON DELETE CASCADE,
  library INTEGER NOT NULL REFERENCES library,
  kernel TEXT NOT NULL,              -- 'evaluate', 'factor', 'solve', 'pack', 'meeting', 'step'
  shape INTEGER NOT NULL REFERENCES shape,
  strategy INTEGER NOT NULL REFERENCES strategy,
  seconds REAL NOT NULL,             -- median of one call, which serves all lanes
  spread REAL NOT NULL,              -- median absolute deviation, s
  repetitions INTEGER NOT NULL,
  backward_error REAL,               -- of the result that was timed, the worst over lanes; NULL: not measured
  forward_error REAL,
  checksum INTEGER NOT NULL          -- over this row and all that it refers to; one that differs is not believed
) STRICT;
INSERT INTO sample VALUES(1,'b8ca219c42554be4236bd54ad0657da9',1,1,'pack',1,1,2.21706250158604234457e-06,0.0,1,NULL,NULL,6217298310589011769);
INSERT INTO sample VALUES(22,'3c56ac902ed5632d8ec4f40e0754969e',1,2,'evaluate',7,8,2.18901073253570584891e-08,3.0460006042079238299e-10,7168,NULL,NULL,-8954863810229407470);
INSERT INTO sample VALUES(27,'be5b9d48570f93f0a3d0a945bae86101',1,3,'factor',7,8,1.10013822782429460957e-08,2.68974180879179834268e-10,14336,6.79626333435848205104e-17,1.61132470613045790321e-16,7272082060628681136);
INSERT INTO sample VALUES(28,'ca9ab0f85618bc265188a8d710244fd7',1,3,'solve',7,8,1.14425485790989114529e-08,1.38684422680292270056e-10,14336,6.79626333435848205104e-17,1.61132470613045790321e-16,-7785810355309362577);
INSERT INTO sample VALUES(453,'0199c35f27d77d2a3f26653295a05b91',1,3,'factor',19,15,8.93651970798432208811e-06,1.31506029972433979868e-06,70,2.32749518710749706321e-16,1.221534571600166399e-15,-3830935473858016668);
INSERT INTO sample VALUES(454,'ede4d7810417dcfbe8115e51a3c1e72b',1,3,'solve',19,15,8.96056273625756678508e-07,7.30756203025382087591e-09,1120,2.32749518710749706321e-16,1.221534571600166399e-15,-7342834356835332832);
INSERT INTO sample VALUES(760,'6ea9293b6b3c8a2874e332f7dc4dc598',1,2,'evaluate',30,14,1.9887630087282263936e-06,1.03735673419026009451e-08,128,NULL,NULL,-4890510512577622687);
INSERT INTO sample VALUES(889,'e5d78e49c154ee41d85e08ecf7fcd2f6',1,1,'factor',35,1,7.66898448181837361081e-04,7.66898448181837361081e-04,1,8.98459810853620216911e-17,8.88388779345575634645e-16,-6847553309629799426);
INSERT INTO sample VALUES(890,'e2e781b218b1e421619f630ce4d3c7d7',1,1,'solve',35,1,1.14137277069489301718e-05,1.14137277069489301718e-05,2,8.98459810853620216911e-17,8.88388779345575634645e-16,-2117866160923907084);
INSERT INTO sample VALUES(1148,'e88de0136ecbca040b7eb306568af53b',1,2,'evaluate',48,15,2.35049275551795985861e-04,1.46010510185302119605e-05,7,NULL,NULL,-8847442755330347891);
INSERT INTO sample VALUES(1345,'d583151bd8eeac9230a7366f7ff8a485',1,7,'factor',54,19,3.25689979945309460163e-05,4.30998625233769416809e-07,3,9.46424623760613565985e-17,5.55242987090984673045e-16,8961582774935655122);
INSERT INTO sample VALUES(1346,'b38aad2ac5b1138befc47af77f593eec',1,7,'solve',54,19,3.9398974683957768748e-05,3.14505292006170896357e-07,3,9.46424623760613565985e-17,5.55242987090984673045e-16,6120033380491065168);
INSERT INTO sample VALUES(1786,'9e4f70b4ce783f3d0ee57aa5280e6c4a',1,2,'evaluate',71,13,5.05082373811110107043e-08,7.97052814586953648628e-10,3584,NULL,NULL,-9030322866676365198);
INSERT INTO sample VALUES(1814,'3ecbe020c752c28ae87e05577a7a9717',1,5,'factor',71,22,5.00584414070865553036e-07,1.33810713397472431397e-09,192,7.24908871727942236834e-17,1.61132470613045790321e-16,3510922632124492123);
INSERT INTO sample VALUES(1815,'72d1733fd932b7eadb182f0edf9b8d13',1,5,'solve',71,22,5.12862427531822199795e-07,4.4901430289533315822e-10,192,7.24908871727942236834e-17,1.61132470613045790321e-16,-1164632666644536155);
INSERT INTO sample VALUES(1979,'263271a50faceda9d9e7910b634ec41a',1,1,'pack',79,1,4.10937839870466562093e-05,9.27505553835353355879e-07,3,7.00783961270397573201e-16,NULL,2583165377540839652);
INSERT INTO sample VALUES(2173,'1628f54a2c517cfbcae4854bd08c5233',1,1,'pack',86,91,3.89129519013710587372e-06,3.89129519013710587372e-06,8,4.50830609454920740652e-16,NULL,8123471236457624240);
INSERT INTO sample VALUES(2367,'beeaee6913aae93f778def28460c6b97',1,7,'pack',94,19,2.25666203688040030873e-04,2.9322412241485442709e-06,3,1.91933358145290618342e-16,NULL,-2425138751122786150);
INSERT INTO sample VALUES(2561,'e69a73d59c3ca193f055ccb83871ad5f',1,7,'pack',9,136,1.87549588033331462739e-04,7.05904787411286492419e-06,3,1.48029736616687505857e-16,NULL,-1158387652826212912);
INSERT INTO sample VALUES(2734,'9361145a7e392ac357b42e38b58ceb42',1,3,'step',1,8,8.55106685042346648627e-06,8.55106685042346648627e-06,4,1.702341944874118323e-15,NULL,-6064298555832258581);
INSERT INTO sample VALUES(2757,'196aa1c696fc4e07cebd4abafe647edb',1,4,'step',1,109,2.90168820752575092897e-05,2.90168820752575092897e-05,1,1.702341944874118323e-15,NULL,-3226506955391635922);
INSERT INTO sample VALUES(2780,'92c465f2055dd3733904ceb48b1cf16b',1,1,'step',113,1,2.04470502562964194384e-06,2.04470502562964194384e-06,16,8.75813650146591e-17,NULL,7970565796766982038);
INSERT INTO sample VALUES(2803,'6e9da35ff584ecdf983551505641fe89',1,3,'step',114,9,5.66963508016380609861e-06,5.66963508016380609861e-06,4,1.76874144614424289967e-15,NULL,8829929204662199674);
INSERT INTO sample VALUES(2826,'384765e19396cfbcdf5469c434f25d9f',1,1,'step',116,58,7.04970928680069054824e-06,7.04970928680069054824e-06,4,1.702341944874118323e-15,NULL,663793845219824504);
INSERT INTO sample VALUES(3114,'65c09f0430b85684dc74f7ecc9f6fac1',1,2,'evaluate',131,10,1.14607705240378478033e-05,1.05574595548387504054e-07,14,NULL,NULL,8875973969699305110);
CREATE TABLE shape (                 -- what is solved: the members of assur::Shape
  id INTEGER PRIMARY KEY,
  n INTEGER NOT NULL,                -- unknowns
  nnz INTEGER NOT NULL,              -- nonzeros of the Jacobian
  groups INTEGER NOT NULL,           -- of the class
  rhs INTEGER NOT NULL,              -- right-hand sides of one factorisation
  fill INTEGER NOT NULL,             -- nonzeros of L + U with Markowitz pivots; 0: not counted
  operations INTEGER NOT NULL,       -- multiplications of a factorisation
  depth INTEGER NOT NULL,            -- rows that wait for each other in a solution
  terms INTEGER NOT NULL,            -- of the equations; 0: a bare matrix
  pattern TEXT NOT NULL,             -- 16 hexadecimal digits that only equal patterns have
  UNIQUE (n, nnz, groups, rhs, fill, operations, depth, terms, pattern)
) STRICT;
INSERT INTO shape VALUES(1,15,48,6,3,60,87,13,129,'bf3792137a72c9c6');
INSERT INTO shape VALUES(7,2,4,1,3,4,5,4,18,'872d4ca90f2df733');
INSERT INTO shape VALUES(9,4,10,1,3,10,12,6,38,'12d0879f8eda8b62');
INSERT INTO shape VALUES(19,27,729,1,1,729,6930,54,0,'2a68a9a3fd50e49f');
INSERT INTO shape VALUES(30,144,430,1,3,430,502,146,1438,'3e089d695f80b6ad');
INSERT INTO shape VALUES(35,251,63001,1,1,63001,5302626,502,0,'abe64ad27b37731f');
INSERT INTO shape VALUES(48,4000,11998,1,3,11998,13998,4002,39998,'afe7d5b06889c933');
INSERT INTO shape VALUES(54,22,132,1,1,233,817,26,0,'36a85c1bb02f2416');
INSERT INTO shape VALUES(71,3,9,1,3,9,14,6,48,'3601f87cef8415aa');
INSERT INTO shape VALUES(79,60,180,8,3,208,297,33,630,'9e9a279a2a4f58e5');
INSERT INTO shape VALUES(86,15,48,1002,3,60,87,13,129,'bf3792137a72c9c6');
INSERT INTO shape VALUES(94,24,72,8,3,82,117,15,252,'7194faaf8c645a65');
INSERT INTO shape VALUES(113,2,4,3,3,4,5,4,18,'872d4ca90f2df733');
INSERT INTO shape VALUES(114,2,4,64,3,4,5,4,18,'872d4ca90f2df733');
INSERT INTO shape VALUES(116,3,9,6,3,9,14,6,48,'3601f87cef8415aa');
INSERT INTO shape VALUES(131,662,1986,1,3,2315,3307,224,6952,'58dc0fb08883144b');
CREATE TABLE strategy (
  id INTEGER PRIMARY KEY,
  text TEXT NOT NULL UNIQUE,         -- 'irreducible/lanes:8+once 2x1'; what follows is taken from it, for the views
  backend TEXT NOT NULL,
  lanes INTEGER NOT NULL,            -- W: instances that one call serves
  p INTEGER NOT NULL,                -- packs at once
  q INTEGER NOT NULL                 -- threads within each
) STRICT;
INSERT INTO strategy VALUES(1,'groups/eigen','eigen',1,1,1);
INSERT INTO strategy VALUES(8,'groups/lanes','lanes',1,1,1);
INSERT INTO strategy VALUES(9,'groups/lanes 2x1','lanes',1,2,1);
INSERT INTO strategy VALUES(10,'groups/lanes:8','lanes',8,1,1);
INSERT INTO strategy VALUES(13,'groups/lanes:2','lanes',2,1,1);
INSERT INTO strategy VALUES(14,'groups/lanes:4','lanes',4,1,1);
INSERT INTO strategy VALUES(15,'groups/lanes:16','lanes',16,1,1);
INSERT INTO strategy VALUES(19,'groups/mumps','mumps',1,1,1);
INSERT INTO strategy VALUES(22,'groups/team+float','team',1,1,1);
INSERT INTO strategy VALUES(58,'irreducible/eigen:8','eigen',8,1,1);
INSERT INTO strategy VALUES(91,'groups/eigen:2','eigen',2,1,1);
INSERT INTO strategy VALUES(109,'groups/lapack:8+once','lapack',8,1,1);
INSERT INTO strategy VALUES(136,'global/mumps+separate','mumps',1,1,1);
CREATE TABLE tuning_run (
  id INTEGER PRIMARY KEY,
  uid TEXT NOT NULL UNIQUE,          -- 32 hexadecimal digits, drawn at random
  machine INTEGER NOT NULL REFERENCES machine,
  profile TEXT NOT NULL,             -- 'quick', 'standard', 'patient', ...
  assur TEXT NOT NULL,               -- version that measured
  started TEXT NOT NULL,             -- UTC, '2026-11-21T18:04:05Z'
  threads INTEGER NOT NULL,          -- budget: cores, quota and OMP_NUM_THREADS together
  load REAL NOT NULL,                -- average of the last minute when it started; -1: not known
  microcode TEXT NOT NULL,
  process INTEGER NOT NULL,          -- number of the process that works on it, or did last
  finished TEXT,                     -- UTC; NULL and what follows: not finished, it can be resumed
  grade TEXT,                        -- 'good', 'fair', 'noisy'
  seconds REAL,                      -- that it took
  coverage REAL,                     -- of what was planned, 0 to 1
  note TEXT
) STRICT;
INSERT INTO tuning_run VALUES(1,'dd1846768cd7912a4a24a80558815e45',1,'quick','0.1.0','2026-11-23T16:11:06Z',2,4.2734375,'0x1000065',17115,'2026-11-23T16:11:36Z','noisy',3.00067189879991929051e+01,8.30065359477124231624e-01,'the load was 2.1 for each processor before it began; the hypervisor took 2 % of the time; the processor was taken away during 3 % of the measurements');
CREATE INDEX sample_of_run ON sample (run);
CREATE TRIGGER sample_added AFTER INSERT ON sample BEGIN DELETE FROM fit; END;
CREATE TRIGGER sample_changed AFTER UPDATE ON sample BEGIN DELETE FROM fit; END;
CREATE TRIGGER sample_removed AFTER DELETE ON sample BEGIN DELETE FROM fit; END;
CREATE VIEW measured AS
SELECT r.machine, s.kernel, s.shape, s.strategy,
       s.seconds / CASE WHEN s.kernel IN ('step', 'meeting') THEN 1 ELSE t.lanes END AS seconds,
       s.spread / s.seconds AS scatter, s.backward_error, s.forward_error, max(s.id) AS sample
FROM sample s JOIN tuning_run r ON r.id = s.run JOIN strategy t ON t.id = s.strategy
GROUP BY r.machine, s.kernel, s.shape, s.strategy;
CREATE VIEW cost AS
SELECT machine, kernel, shape, strategy, seconds, backward_error, forward_error FROM measured
UNION ALL
SELECT f.machine, 'factor+3solve', f.shape, f.strategy, f.seconds + 3 * s.seconds,
       s.backward_error, s.forward_error
FROM measured f JOIN measured s USING (machine, shape, strategy)
WHERE f.kernel = 'factor' AND s.kernel = 'solve';
CREATE VIEW best_strategy AS
WITH ranked AS (
  SELECT machine, kernel, shape, strategy, seconds,
         row_number() OVER rank AS place,
         lead(strategy) OVER rank AS next, lead(seconds) OVER rank AS next_seconds
  FROM cost WHERE kernel != 'meeting'
  WINDOW rank AS (PARTITION BY machine, kernel, shape ORDER BY seconds, strategy)
)
SELECT m.fingerprint AS machine, b.kernel, h.n, h.nnz, h.fill, h.groups, h.rhs, h.pattern, t.text AS strategy,
       b.seconds AS seconds, u.text AS runner_up, b.next_seconds / b.seconds AS runner_up_takes
FROM ranked b JOIN machine m ON m.id = b.machine JOIN shape h ON h.id = b.shape
JOIN strategy t ON t.id = b.strategy LEFT JOIN strategy u ON u.id = b.next
WHERE b.place = 1
ORDER BY m.fingerprint, b.kernel, h.n, h.nnz, h.groups;
CREATE VIEW crossovers AS
WITH line AS (
  SELECT machine, kernel, nnz = n * n AS dense, groups, rhs, n, nnz, strategy,
         lag(n) OVER growing AS n_before, lag(strategy) OVER growing AS strategy_before
  FROM best_strategy
  WINDOW growing AS (PARTITION BY machine, kernel, nnz = n * n, groups, rhs ORDER BY n, nnz, pattern)
)
SELECT machine, kernel, dense, groups, rhs, n_before, strategy_before, n, strategy
FROM line WHERE strategy != strategy_before;
CREATE VIEW error_against_time AS
SELECT m.fingerprint AS machine, c.kernel, h.n, h.nnz, h.groups, h.rhs, h.pattern, t.text AS strategy,
       c.seconds AS seconds, c.backward_error, c.forward_error,
       NOT EXISTS (SELECT 1 FROM cost o
                   WHERE o.machine = c.machine AND o.kernel = c.kernel AND o.shape = c.shape
                     AND o.seconds < c.seconds AND o.backward_error <= c.backward_error) AS on_front
FROM cost c JOIN machine m ON m.id = c.machine JOIN shape h ON h.id = c.shape
JOIN strategy t ON t.id = c.strategy
WHERE c.backward_error IS NOT NULL
ORDER BY m.fingerprint, c.kernel, h.n, h.nnz, h.groups, c.seconds;
COMMIT;
