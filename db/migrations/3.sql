-- The fitted model is made anew by whoever reads the samples. Lost samples are told by a count of them.
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
