CREATE TABLE fit (                   -- the model as the runtime reads it in place of all samples; can be made anew
  machine INTEGER PRIMARY KEY REFERENCES machine ON DELETE CASCADE,
  content BLOB NOT NULL,             -- PerformanceModel::bytes(), of the build that the libraries are of, and a
                                     -- checksum over the rest of the file: where it differs the samples are read
  checksum INTEGER NOT NULL          -- over the content; one that differs is not believed
) STRICT;
-- A fit is valid only for the present samples.
CREATE TRIGGER sample_added AFTER INSERT ON sample BEGIN DELETE FROM fit; END;
CREATE TRIGGER sample_changed AFTER UPDATE ON sample BEGIN DELETE FROM fit; END;
CREATE TRIGGER sample_removed AFTER DELETE ON sample BEGIN DELETE FROM fit; END;
