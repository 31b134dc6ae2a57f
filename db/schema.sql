-- The tuning database of assur, version 4. This file is the only description of its tables, and is built into the
-- library. Units: seconds, bytes. Kernels, strategies and libraries are stored by name, because another version could
-- number them differently. db/README.md explains queries by hand.

CREATE TABLE machine (
  id INTEGER PRIMARY KEY,
  fingerprint TEXT NOT NULL UNIQUE,  -- 16 hexadecimal digits over the columns from vendor to numa_nodes
  vendor TEXT NOT NULL,              -- of the processor; vendor '' and numbers -1: the processor does not tell
  family INTEGER NOT NULL,
  model INTEGER NOT NULL,
  stepping INTEGER NOT NULL,
  name TEXT NOT NULL,
  instructions TEXT NOT NULL,        -- the widest set for which assur has code: 'AVX2', 'AVX3', ...
  cores INTEGER NOT NULL,            -- physical cores that the affinity mask allowed
  processors INTEGER NOT NULL,       -- logical processors; more than cores if a core runs two threads
  quota REAL NOT NULL,               -- number of processors that control groups allowed; 0: no limit
  caches TEXT NOT NULL,              -- of the first core: level:bytes:cores that share the cache; separated by blanks
  numa_nodes INTEGER NOT NULL,
  memory INTEGER NOT NULL            -- bytes when the machine was first seen; not in the fingerprint
) STRICT;

CREATE TABLE library (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,                -- name of a backend, or 'assur' for all other code
  version TEXT NOT NULL,             -- 'OpenBLAS 0.3.21, OpenMP, SkylakeX'; of assur if there is no library
  build TEXT NOT NULL,               -- compiler and kind of build: 'GNU 12.2.0 Release'
  UNIQUE (name, version, build)
) STRICT;

CREATE TABLE tuning_run (
  id INTEGER PRIMARY KEY,
  uid TEXT NOT NULL UNIQUE,          -- 32 hexadecimal digits, drawn at random
  machine INTEGER NOT NULL REFERENCES machine,
  profile TEXT NOT NULL,             -- 'quick', 'standard', 'patient', ...
  assur TEXT NOT NULL,               -- version of assur that measured
  started TEXT NOT NULL,             -- UTC, '2026-11-21T18:04:05Z'
  threads INTEGER NOT NULL,          -- the budget, from cores, quota and OMP_NUM_THREADS
  load REAL NOT NULL,                -- load average of the minute before the start; -1: not known
  microcode TEXT NOT NULL,
  process INTEGER NOT NULL,          -- number of the process that works on this run, or was the last to do so
  finished TEXT,                     -- UTC; this and the next four columns are NULL until the run is finished
  grade TEXT,                        -- 'good', 'fair', 'noisy'
  seconds REAL,                      -- duration of the run
  coverage REAL,                     -- share of the planned samples that were taken, 0 to 1
  note TEXT,
  samples INTEGER NOT NULL DEFAULT 0  -- counted by the triggers below; if fewer are found, samples were lost
) STRICT;

CREATE TABLE shape (                 -- sizes of a group or matrix: the members of assur::Shape
  id INTEGER PRIMARY KEY,
  n INTEGER NOT NULL,                -- unknowns
  nnz INTEGER NOT NULL,              -- nonzeros of the Jacobian
  groups INTEGER NOT NULL,           -- number of groups of the class
  rhs INTEGER NOT NULL,              -- right-hand sides of one factorisation
  fill INTEGER NOT NULL,             -- nonzeros of L + U with Markowitz pivots; 0: not counted
  operations INTEGER NOT NULL,       -- multiplications of a factorisation
  depth INTEGER NOT NULL,            -- longest chain of rows that wait for each other in a solution
  terms INTEGER NOT NULL,            -- number of terms of the equations; 0: a bare matrix
  pattern TEXT NOT NULL,             -- 16 hexadecimal digits, different for different patterns
  one_program INTEGER NOT NULL,      -- 1: the step of a group can be one program
  UNIQUE (n, nnz, groups, rhs, fill, operations, depth, terms, pattern, one_program)
) STRICT;

CREATE TABLE strategy (
  id INTEGER PRIMARY KEY,
  text TEXT NOT NULL UNIQUE,         -- 'irreducible/lanes:8+once 2x1'; the other columns repeat its parts for the views
  backend TEXT NOT NULL,
  lanes INTEGER NOT NULL,            -- W: number of instances that one call serves
  p INTEGER NOT NULL,                -- packs that are solved at once
  q INTEGER NOT NULL                 -- threads within each pack
) STRICT;

CREATE TABLE sample (
  id INTEGER PRIMARY KEY,
  uid TEXT NOT NULL UNIQUE,          -- 32 hexadecimal digits, drawn at random; identifies a sample in all databases
  run INTEGER NOT NULL REFERENCES tuning_run ON DELETE CASCADE,
  library INTEGER NOT NULL REFERENCES library,
  kernel TEXT NOT NULL,              -- 'evaluate', 'factor', 'solve', 'pack', 'meeting', 'step', 'around'
  shape INTEGER NOT NULL REFERENCES shape,
  strategy INTEGER NOT NULL REFERENCES strategy,
  seconds REAL NOT NULL,             -- median time of one call, which serves all lanes, by the clock
  spread REAL NOT NULL,              -- median absolute deviation at a constant pace, s
  repetitions INTEGER NOT NULL,
  backward_error REAL,               -- of the timed result, largest of all lanes; NULL: not measured
  forward_error REAL,
  checksum INTEGER NOT NULL,         -- of this row and all rows that it refers to; if it differs, the row is not used
  slowness REAL                      -- time of a fixed piece of work at the same moment, s; NULL: not known, and
                                     -- `seconds` are at the pace that was usual then
) STRICT;
CREATE INDEX sample_of_run ON sample (run);

CREATE TABLE model (                 -- results of the last tuning run of each profile
  machine INTEGER NOT NULL REFERENCES machine ON DELETE CASCADE,
  name TEXT NOT NULL,
  made TEXT NOT NULL,                -- UTC
  assur TEXT NOT NULL,               -- version of assur that computed it
  content TEXT NOT NULL,             -- JSON: how the run went, and the regret on samples that the fit did not use
  PRIMARY KEY (machine, name)
) STRICT;

CREATE TRIGGER sample_added AFTER INSERT ON sample
BEGIN UPDATE tuning_run SET samples = samples + 1 WHERE id = new.run; END;
CREATE TRIGGER sample_removed AFTER DELETE ON sample
BEGIN UPDATE tuning_run SET samples = samples - 1 WHERE id = old.run; END;

-- Views for people. Each time is that of one instance: the time of a call, divided by the lanes that the call serves.

-- The usual pace of a machine, by version and build of assur: the lower quartile of the slowness, s.
CREATE VIEW usual_pace AS
SELECT machine, assur, build, slowness
FROM (SELECT r.machine, r.assur, l.build, s.slowness, row_number() OVER fastest AS place,
             count(*) OVER (PARTITION BY r.machine, r.assur, l.build) AS samples
      FROM sample s JOIN tuning_run r ON r.id = s.run JOIN library l ON l.id = s.library
      WHERE s.slowness IS NOT NULL
      WINDOW fastest AS (PARTITION BY r.machine, r.assur, l.build ORDER BY s.slowness))
WHERE place = (samples + 3) / 4;

-- The newest sample of each cell, at the usual pace. The pace is that of one core: it does not change the times of
-- several threads and of GPUs.
CREATE VIEW measured AS
SELECT r.machine, s.kernel, s.shape, s.strategy,
       s.seconds * CASE WHEN t.p * t.q > 1 OR t.backend IN ('cusolver', 'magma') THEN 1
                        ELSE coalesce(u.slowness / s.slowness, 1) END
                 / CASE WHEN s.kernel IN ('step', 'around') THEN 1 ELSE t.lanes END AS seconds,
       s.spread / s.seconds AS scatter, s.slowness / u.slowness AS slowness, s.backward_error, s.forward_error,
       max(s.id) AS sample
FROM sample s JOIN tuning_run r ON r.id = s.run JOIN strategy t ON t.id = s.strategy
JOIN library l ON l.id = s.library
LEFT JOIN usual_pace u ON u.machine = r.machine AND u.assur = r.assur AND u.build = l.build
GROUP BY r.machine, s.kernel, s.shape, s.strategy;

-- The same, with a further kernel 'factor+3solve': the linear algebra of a step.
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
  FROM cost WHERE kernel NOT IN ('meeting', 'around')
  WINDOW rank AS (PARTITION BY machine, kernel, shape ORDER BY seconds, strategy)
)
SELECT m.fingerprint AS machine, b.kernel, h.n, h.nnz, h.fill, h.groups, h.rhs, h.pattern, t.text AS strategy,
       b.seconds AS seconds, u.text AS runner_up, b.next_seconds / b.seconds AS runner_up_takes
FROM ranked b JOIN machine m ON m.id = b.machine JOIN shape h ON h.id = b.shape
JOIN strategy t ON t.id = b.strategy LEFT JOIN strategy u ON u.id = b.next
WHERE b.place = 1
ORDER BY m.fingerprint, b.kernel, h.n, h.nnz, h.groups;

-- The sizes n at which another strategy becomes the best; dense and sparse matrices separately.
CREATE VIEW crossovers AS
WITH line AS (
  SELECT machine, kernel, nnz = n * n AS dense, groups, rhs, n, nnz, strategy,
         lag(n) OVER growing AS n_before, lag(strategy) OVER growing AS strategy_before
  FROM best_strategy
  WINDOW growing AS (PARTITION BY machine, kernel, nnz = n * n, groups, rhs ORDER BY n, nnz, pattern)
)
SELECT machine, kernel, dense, groups, rhs, n_before, strategy_before, n, strategy
FROM line WHERE strategy != strategy_before;

-- Accuracy and time of every strategy; on_front: no other strategy is both faster and at least as exact.
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
