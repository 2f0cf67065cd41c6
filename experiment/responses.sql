-- The tables of responses.sqlite, schema version 2. SQLite keeps these comments in the file. docs/responses.md says more.
CREATE TABLE log (                                                    -- one row
  id      INTEGER PRIMARY KEY CHECK (id = 1),
  station TEXT NOT NULL CHECK (station <> '')                         -- random: tells computers apart when logs are merged
) STRICT;

CREATE TABLE participant (
  id   INTEGER PRIMARY KEY,          -- by the log
  code TEXT NOT NULL UNIQUE          -- by the experimenter; planted subjects: planted-SEED-INDEX
    CHECK (code <> '')
) STRICT;

CREATE TABLE session (
  id                 INTEGER PRIMARY KEY,                             -- by the log
  uuid               TEXT NOT NULL UNIQUE CHECK (uuid <> ''),         -- random: the same session in any log
  station            TEXT NOT NULL CHECK (station <> ''),             -- log.station of the log it was begun in
  participant        INTEGER NOT NULL REFERENCES participant (id),
  kind               TEXT NOT NULL CHECK (kind IN ('person', 'planted', 'looking')),
  experiment         TEXT NOT NULL CHECK (experiment IN ('artifact', 'material')),
  subject_index      INTEGER NOT NULL CHECK (subject_index >= 0),     -- decides sides, views, materials
  seed               INTEGER NOT NULL CHECK (seed >= 0),              -- decides the order of trials
  program_version    TEXT NOT NULL,                                   -- of equilux-session at the start
  study_digest       TEXT NOT NULL,                                   -- SHA-256, hexadecimal, as all digests
  manifest_digest    TEXT NOT NULL,                                   -- of all pictures that may be shown
  windows_digest     TEXT NOT NULL,                                   -- '' in material sessions
  selection_digest   TEXT NOT NULL,                                   -- '' in artifact sessions
  truth_digest       TEXT NOT NULL,                                   -- '' unless planted
  protocol_digest    TEXT NOT NULL,                                   -- of session.json; '' before schema 2
  monitor            TEXT NOT NULL,                                   -- the system's name; '' if simulated
  framebuffer_width  INTEGER,                                         -- pixels
  framebuffer_height INTEGER,                                         -- pixels
  viewing_distance_m REAL,                                            -- metres
  degrees_wide       REAL,                                            -- degrees, of one picture, as achieved
  degrees_high       REAL,                                            -- degrees, of one picture, as achieved
  started_utc        TEXT NOT NULL,                                   -- system clock, ISO 8601
  complete           INTEGER NOT NULL DEFAULT 0 CHECK (complete IN (0, 1)),  -- set at the very end
  UNIQUE (station, kind, experiment, subject_index)
) STRICT;

CREATE TABLE field (
  session INTEGER NOT NULL REFERENCES session (id),
  name    TEXT NOT NULL CHECK (name <> ''),                           -- consent_version, age_band, refresh_hz, ...
  value   TEXT NOT NULL,
  UNIQUE (session, name)
) STRICT;

CREATE TABLE trial (
  session          INTEGER NOT NULL REFERENCES session (id),
  trial            INTEGER NOT NULL CHECK (trial >= 0),               -- 0, 1, ...: order of showing
  phase            TEXT NOT NULL                                      -- main alone is counted
    CHECK (phase = 'main' OR phase = 'catch' OR phase = 'practice'),  -- IN would build a table to look it up
  cell             TEXT NOT NULL,                                     -- what is counted: G1-MR-ind-100k-C4
  test_key         TEXT NOT NULL,                                     -- the VPL picture
  pair_key         TEXT NOT NULL,                                     -- the reference beside it
  upper_key        TEXT NOT NULL,                                     -- the reference above; '' in artifact trials
  test_side        TEXT NOT NULL CHECK (test_side IN ('left', 'right')),
  answer           TEXT CHECK (answer IN ('left', 'right')),          -- the side pressed; empty until then
  response_time_ns INTEGER CHECK (response_time_ns > 0),              -- monotonic clock, onset to press
  answered_utc     TEXT,                                              -- system clock, ISO 8601
  too_fast         INTEGER NOT NULL DEFAULT 0 CHECK (too_fast IN (0, 1)),  -- under the protocol's least time
  UNIQUE (session, trial),
  CHECK ((answer IS NULL) = (response_time_ns IS NULL) AND (answer IS NULL) = (answered_utc IS NULL))
) STRICT;

CREATE TABLE event (
  id           INTEGER PRIMARY KEY,                                   -- by the log: order of recording
  session      INTEGER NOT NULL REFERENCES session (id),
  trial        INTEGER,                                               -- of showings and answers, else empty
  kind         TEXT NOT NULL CHECK (kind <> ''),                      -- showing, answer, resume, abort, finish, ...
  time_ns      INTEGER NOT NULL,                                      -- monotonic clock of the running program
  recorded_utc TEXT NOT NULL,                                         -- system clock, ISO 8601
  detail       TEXT NOT NULL,                                         -- free text
  FOREIGN KEY (session, trial) REFERENCES trial (session, trial)
) STRICT;

CREATE TABLE tombstone (
  salt          TEXT NOT NULL,                                        -- random, hexadecimal
  digest        TEXT NOT NULL,                                        -- SHA-256 of salt and withdrawn code
  withdrawn_utc TEXT NOT NULL,                                        -- system clock, ISO 8601
  UNIQUE (salt, digest)
) STRICT;

CREATE TABLE export (
  id       INTEGER PRIMARY KEY,                                       -- by the log
  path     TEXT NOT NULL,                                             -- where the files went
  made_utc TEXT NOT NULL                                              -- system clock, ISO 8601
) STRICT;
