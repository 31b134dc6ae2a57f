-- Readers of the samples fit the model themselves. A count of the samples of each run shows lost ones.
DROP TRIGGER sample_added;
DROP TRIGGER sample_changed;
DROP TRIGGER sample_removed;
DROP TABLE fit;
ALTER TABLE tuning_run ADD COLUMN samples INTEGER NOT NULL DEFAULT 0;
UPDATE tuning_run SET samples = (SELECT count(*) FROM sample WHERE run = tuning_run.id);
CREATE TRIGGER sample_added AFTER INSERT ON sample
BEGIN UPDATE tuning_run SET samples = samples + 1 WHERE id = new.run; END;
CREATE TRIGGER sample_removed AFTER DELETE ON sample
BEGIN UPDATE tuning_run SET samples = samples - 1 WHERE id = old.run; END;
-- Times by the clock, with the slowness of the machine.
ALTER TABLE sample ADD COLUMN slowness REAL;
DROP VIEW measured;
DROP VIEW best_strategy;
CREATE VIEW usual_pace AS
SELECT machine, assur, build, slowness
FROM (SELECT r.machine, r.assur, l.build, s.slowness, row_number() OVER fastest AS place,
             count(*) OVER (PARTITION BY r.machine, r.assur, l.build) AS samples
      FROM sample s JOIN tuning_run r ON r.id = s.run JOIN library l ON l.id = s.library
      WHERE s.slowness IS NOT NULL
      WINDOW fastest AS (PARTITION BY r.machine, r.assur, l.build ORDER BY s.slowness))
WHERE place = (samples + 3) / 4;
CREATE VIEW measured AS
SELECT r.machine, s.kernel, s.shape, s.strategy,
       CASE WHEN s.kernel = 'meeting'
            THEN min(s.seconds, 5e-6) + max(s.seconds - 5e-6, 0) * coalesce(u.slowness / s.slowness, 1)
            ELSE s.seconds * coalesce(u.slowness / s.slowness, 1)
                 / CASE WHEN s.kernel IN ('step', 'around') THEN 1 ELSE t.lanes END END AS seconds,
       s.spread / s.seconds AS scatter, s.slowness / u.slowness AS slowness, s.backward_error, s.forward_error,
       max(s.id) AS sample
FROM sample s JOIN tuning_run r ON r.id = s.run JOIN strategy t ON t.id = s.strategy
JOIN library l ON l.id = s.library
LEFT JOIN usual_pace u ON u.machine = r.machine AND u.assur = r.assur AND u.build = l.build
GROUP BY r.machine, s.kernel, s.shape, s.strategy;
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
