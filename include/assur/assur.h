/* assur for C, and for languages that call C. Units are SI, angles are in rad; docs/c.md has examples.

   Results. A function that returns int32_t gives 0 (ASSUR_OK) or another numerical outcome (> 0, enum assur_code), or
   an error (< 0, enum assur_error_kind): misuse, bad input, or a machine that cannot do what was asked. After an error
   nothing has changed unless the function says more, and assur_error() gives the text. NULL instead of a handle, name
   or array is an error, too; a pointer that is neither NULL nor valid is not found out. No function prints or aborts.

   Handles (assur_scene, assur_plan, ...) belong to the caller, who ends each with its _free function; NULL may be
   freed. A handle needs no other one after it was made. One thread at a time may use a handle; plans and scenes may be
   read by several at once. Texts that functions return belong to the handle, and are valid until its next call that is
   not const.

   Functions above the mark "assur" are in the library assur_core, the others in assur. */
#ifndef ASSUR_H
#define ASSUR_H

#include <stddef.h>
#include <stdint.h>

#include "assur/version.hpp" /* ASSUR_VERSION: macros only */

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this interface. It changes when a program must be compiled again; functions, enumerators and members at
   the end of structs with a size may be added without. */
#define ASSUR_ABI 1

/* ASSUR_ABI and ASSUR_VERSION of the library that the program runs with. */
int32_t assur_abi(void);
const char* assur_version(void);

/* ---- outcomes and errors */

/* Outcome of a step or run: assur::Code, docs/accuracy.md. The numbers are never changed. */
enum assur_code {
  ASSUR_OK = 0,
  ASSUR_SINGULAR = 1,
  ASSUR_NOT_FINITE = 2,
  ASSUR_NOT_CONVERGED = 3,
  ASSUR_FOLD = 4,
  ASSUR_CHANGE_POINT_PASSED = 5,
  ASSUR_INACCURATE = 6, /* the time was reached, but the estimated error exceeds the required accuracy */
  ASSUR_BRANCH_UNKNOWN = 7,
  ASSUR_INCONSISTENT = 8,
  ASSUR_OUT_OF_RANGE = 9,
  ASSUR_ACTUATOR_ZERO = 10,
  ASSUR_DEADLINE = 11,
  ASSUR_INTERRUPTED = 12,
  ASSUR_LIMIT_REACHED = 13,
  ASSUR_LIMIT_EXCEEDED = 14,
  ASSUR_WITHIN_LIMITS = 15,
  ASSUR_NOT_ASSEMBLED = 17,
  ASSUR_NEAR_SINGULAR = 18
};

enum assur_error_kind {
  ASSUR_ERROR_INPUT = -1,       /* wrong use, or a wrong scene */
  ASSUR_ERROR_NUMERICAL = -2,   /* a computation that fails, e.g. the assembly of a mechanism */
  ASSUR_ERROR_ENVIRONMENT = -3, /* the machine: no memory, a file that cannot be read, a backend that cannot run */
  ASSUR_ERROR_INTERNAL = -4     /* a fault of the library; please report it */
};

/* The object that a status is about. */
enum assur_place {
  ASSUR_PLACE_NONE = 0,
  ASSUR_PLACE_DRIVER = 1,
  ASSUR_PLACE_GROUP = 2,
  ASSUR_PLACE_LANE = 3,
  ASSUR_PLACE_MEMBER = 4,
  ASSUR_PLACE_TARGET = 5, /* a controlled driver: its number is that of assur_simulator_driver() */
  ASSUR_PLACE_LIMIT = 6   /* a limited quantity, which assur_simulator_place_name() names */
};

typedef struct assur_status {
  int32_t code;   /* enum assur_code */
  int32_t place;  /* enum assur_place */
  int32_t index;  /* of the place, counted from 0; -1: none */
  int32_t unused; /* 0 */
  double figure;  /* depends on the code: docs/accuracy.md; 0: none */
} assur_status;

/* Name ("fold") and explanation of an outcome; "unknown" for other numbers. */
const char* assur_code_name(int32_t code);
const char* assur_code_explanation(int32_t code);

/* The last error of this thread: one line for each finding, "where: what"; "" before the first one. Valid until the
   next error of this thread. */
const char* assur_error(void);
/* Its findings: their number; the place in the scene (a JSON pointer; "": none) and the text of one of them, "" beyond
   their number. */
size_t assur_error_count(void);
const char* assur_error_where(size_t finding);
const char* assur_error_what(size_t finding);

/* ---- plans: scenes that are ready to run */

typedef struct assur_plan assur_plan;

/* Reads a plan that assur_plan_save() or `assur plan --save` wrote, from a file or from text. threads: largest number
   of threads; 0: those of this machine. */
int32_t assur_plan_load(const char* file, int32_t threads, assur_plan** plan);
int32_t assur_plan_read(const char* text, size_t length, int32_t threads, assur_plan** plan);
/* Saves a plan, which needs no scene and no library but assur_core then. */
int32_t assur_plan_save(const assur_plan* plan, const char* file);
void assur_plan_free(assur_plan* plan);

/* Name of the scene; NULL for NULL. */
const char* assur_plan_name(const assur_plan* plan);
/* The time grid, s; each pointer may be NULL. A scene without one has three zeros. */
int32_t assur_plan_time(const assur_plan* plan, double* start, double* end, double* step);

/* ---- simulators */

typedef struct assur_simulator assur_simulator;
typedef struct assur_state assur_state;

/* Settings of steps: StepSettings in assur/step_settings.hpp. Begin with ASSUR_STEP_SETTINGS. */
typedef struct assur_step_settings {
  size_t size;             /* sizeof(assur_step_settings) */
  int32_t iterations;      /* 0: until they converge */
  int32_t most_iterations; /* at least 1 */
  double seconds;          /* 0: no time limit */
  const int32_t* pin_to;   /* processors; NULL: none */
  size_t pin_count;
  int32_t (*stop)(void* context); /* returns other than 0 to end a divided step; NULL: not called */
  void* stop_context;
} assur_step_settings;
#define ASSUR_STEP_SETTINGS \
  { sizeof(assur_step_settings), 0, 12, 0.0, NULL, 0, NULL, NULL }

/* A simulator at the start posture. settings: NULL for ASSUR_STEP_SETTINGS. */
int32_t assur_simulator_new(const assur_plan* plan, const assur_step_settings* settings, assur_simulator** simulator);
void assur_simulator_free(assur_simulator* simulator);

/* Number, name (NULL beyond the number) and index of the outputs ("C.x") and of the controlled drivers. A control loop
   asks for an index once, and then uses no text. */
size_t assur_simulator_column_count(const assur_simulator* simulator);
const char* assur_simulator_column_name(const assur_simulator* simulator, size_t column);
int32_t assur_simulator_column(const assur_simulator* simulator, const char* name, size_t* column);
size_t assur_simulator_driver_count(const assur_simulator* simulator);
const char* assur_simulator_driver_name(const assur_simulator* simulator, size_t driver);
int32_t assur_simulator_driver(const assur_simulator* simulator, const char* name, size_t* driver);

/* Sets the target of a controlled driver for the next step: value, rate and acceleration. */
int32_t assur_simulator_set(assur_simulator* simulator, size_t driver, double value, double rate, double acceleration);
/* Moves by one step of the time grid, or by 1 s if there is no time grid. A step that fails returns to the state before
   it and drops its targets. status: may be NULL. Returns its code. */
int32_t assur_simulator_step(assur_simulator* simulator, assur_status* status);
/* Moves to time t, s. If this fails, the simulator keeps the last good posture on the way and drops the targets. */
int32_t assur_simulator_step_to(assur_simulator* simulator, double t, assur_status* status);
/* Name of the object that a status of this simulator is about; "": none, NULL beyond the number of its kind. */
const char* assur_simulator_place_name(const assur_simulator* simulator, int32_t place, int32_t index);
/* 1 if a step with this outcome reached its time: ASSUR_OK or ASSUR_INACCURATE; else 0. */
int32_t assur_arrived(int32_t code);

/* Time of the posture, s; NaN for NULL. */
double assur_simulator_time(const assur_simulator* simulator);
/* All outputs of the posture, in the order of the columns; valid until the next call that is not const. NULL for NULL.
 */
const double* assur_simulator_outputs(const assur_simulator* simulator);

/* Runs from the start posture over `count` times, s, or over the time grid if times is NULL; count is then the number
   of rows for which there is room, which must be enough. The outputs of row k begin at values[k * row_stride]. rows:
   the number of rows that were reached; may be NULL. Returns the code of the status. */
int32_t assur_simulator_run(assur_simulator* simulator, const double* times, size_t count, double* values,
                            size_t row_stride, size_t* rows, assur_status* status);

/* Takes rows of outputs: times[rows] and values[rows * columns]. Returns other than 0 to end the run. */
typedef int32_t (*assur_sink)(void* context, const double* times, const double* values, size_t rows);
/* The same, with rows given to a sink, at most 1,024 at once. every: every n-th row, at least 1. */
int32_t assur_simulator_stream(assur_simulator* simulator, const double* times, size_t count, size_t every,
                               assur_sink sink, void* context, size_t* rows, assur_status* status);

/* Returns to the start posture, and clears report and targets. */
int32_t assur_simulator_reset(assur_simulator* simulator);
/* Returns to the last posture that an undivided step reached. */
int32_t assur_simulator_retreat(assur_simulator* simulator);
/* Saves the state: to a new one if *state is NULL, else to this one. */
int32_t assur_simulator_save(assur_simulator* simulator, assur_state** state);
/* Returns to a state of a simulator of the same plan. */
int32_t assur_simulator_restore(assur_simulator* simulator, const assur_state* state);
void assur_state_free(assur_state* state);

/* Derivatives of the outputs by the controlled drivers, SI units: values[row * row_stride + driver], a row for each
   output without its rates. smallest: smallest singular value; may be NULL. Returns ASSUR_OK, or ASSUR_SINGULAR with
   NaN. */
int32_t assur_simulator_jacobian(assur_simulator* simulator, double* values, size_t row_stride, double* smallest,
                                 assur_status* status);
/* Number and names (NULL beyond the number) of these rows. */
size_t assur_simulator_jacobian_rows(assur_simulator* simulator);
const char* assur_simulator_jacobian_row_name(assur_simulator* simulator, size_t row);

typedef struct assur_report {
  size_t size;         /* sizeof(assur_report), set by the caller */
  assur_status status; /* of the last step that failed, else of the first doubtful one */
  double reached;      /* last time with a valid posture, s */
  int64_t steps, substeps, rejected, newton_iterations, factorizations;
  double residual[3];        /* of position, velocity, acceleration, relative; NaN: not measured */
  double estimated_error[3]; /* of the outputs, relative; NaN: not measured */
  size_t events, fallbacks;  /* their numbers */
} assur_report;
/* Report since the start, a reset, or the begin of a run. */
int32_t assur_simulator_report(const assur_simulator* simulator, assur_report* report);

typedef struct assur_event {
  size_t size;        /* sizeof(assur_event), set by the caller */
  double time, until; /* s; the time lies between them */
  double figure;      /* docs/accuracy.md */
  int32_t code;       /* enum assur_code */
  const char* group;  /* the object that it is about; "": none */
  const char *unit, *detail;
} assur_event;
/* The i-th event of the report, and the i-th deviation from the plan (NULL beyond their number). */
int32_t assur_simulator_event(const assur_simulator* simulator, size_t event, assur_event* out);
const char* assur_simulator_fallback(const assur_simulator* simulator, size_t fallback);

/* ---- ensembles */

typedef struct assur_ensemble assur_ensemble;

/* Members that are plans, all with the same outputs. */
int32_t assur_ensemble_of_plans(const assur_plan* const* plans, size_t count, const assur_step_settings* settings,
                                assur_ensemble** ensemble);
void assur_ensemble_free(assur_ensemble* ensemble);

size_t assur_ensemble_members(const assur_ensemble* ensemble);
size_t assur_ensemble_column_count(const assur_ensemble* ensemble);
const char* assur_ensemble_column_name(const assur_ensemble* ensemble, size_t column);
int32_t assur_ensemble_column(const assur_ensemble* ensemble, const char* name, size_t* column);

/* Runs all members over `count` times, which begin with that of the scene, or over its time grid if times is NULL
   (count as in assur_simulator_run). columns: those that are wanted; NULL: all. The row k of member i begins at
   values[i * member_stride + k * row_stride]; rows that a member did not reach are NaN. rows[i]: rows that it reached;
   may be NULL. Returns the code of the status: that of the first member that failed, else of the first inaccurate one.
 */
int32_t assur_ensemble_run(assur_ensemble* ensemble, const double* times, size_t count, const size_t* columns,
                           size_t column_count, double* values, size_t member_stride, size_t row_stride, size_t* rows,
                           assur_status* status);

typedef struct assur_summary {       /* of one column of a member, over its rows; NaN if there are none */
  double minimum, maximum;           /* SI units */
  double minimum_time, maximum_time; /* s */
  double mean, last;                 /* SI units */
} assur_summary;
/* The same without rows: out[i * member_stride + c] is the summary of columns[c] of member i. */
int32_t assur_ensemble_summarize(assur_ensemble* ensemble, const double* times, size_t count, const size_t* columns,
                                 size_t column_count, assur_summary* out, size_t member_stride, assur_status* status);

typedef struct assur_outcome {
  size_t size; /* sizeof(assur_outcome), set by the caller */
  assur_status status;
  double reached;     /* s */
  const char* cannot; /* reason why the member could not start; "": it started */
} assur_outcome;
/* The end of a member in the last run. */
int32_t assur_ensemble_outcome(const assur_ensemble* ensemble, size_t member, assur_outcome* outcome);

/* ---- assur: scenes, and plans of them */

typedef struct assur_scene assur_scene;

/* Reads a scene: a file (JSON, or MJCF with .xml), or a sample such as "four_bar" or "stewart:legs=6". */
int32_t assur_scene_open(const char* file_or_sample, assur_scene** scene);
/* Reads JSON text. */
int32_t assur_scene_parse(const char* text, size_t length, assur_scene** scene);
void assur_scene_free(assur_scene* scene);
/* Writes it as JSON. */
int32_t assur_scene_write(const assur_scene* scene, const char* file);

/* Name, and the number and names of its parameters (NULL beyond the number). */
const char* assur_scene_name(const assur_scene* scene);
size_t assur_scene_parameter_count(const assur_scene* scene);
const char* assur_scene_parameter_name(const assur_scene* scene, size_t parameter);
/* Sets parameters, or numbers of the scene such as "C.x" (Scene::with_values in assur/scene.hpp). */
int32_t assur_scene_set(assur_scene* scene, const char* const* names, const double* values, size_t count);
/* Replaces the wanted outputs: "C", "C.velocity", "B" of a body, "all" alone. */
int32_t assur_scene_set_outputs(assur_scene* scene, const char* const* names, size_t count);
/* Replaces the time grid, s. */
int32_t assur_scene_set_time(assur_scene* scene, double start, double end, double step);

enum assur_mode { ASSUR_LATENCY = 0, ASSUR_THROUGHPUT = 1 };

/* PrepareOptions in assur/plan.hpp. Begin with ASSUR_OPTIONS. */
typedef struct assur_options {
  size_t size;                   /* sizeof(assur_options) */
  const char* strategy;          /* NULL: "auto" */
  const char* const* controlled; /* names of drivers that the program sets; NULL: none */
  size_t controlled_count;
  int32_t threads;            /* largest number; 0: those of this machine */
  int32_t mode;               /* enum assur_mode */
  double accuracy;            /* required accuracy of the outputs; 0: as exact as doubles allow */
  const char* const* without; /* ids of backends that must not be used; NULL: none */
  size_t without_count;
} assur_options;
#define ASSUR_OPTIONS \
  { sizeof(assur_options), NULL, NULL, 0, 0, ASSUR_LATENCY, 0.0, NULL, 0 }

/* Analyses a scene and makes a plan. options: NULL for ASSUR_OPTIONS. */
int32_t assur_prepare(const assur_scene* scene, const assur_options* options, assur_plan** plan);

/* Members that are rows of a table: values[i * member_stride + k] is the value of names[k] in member i. */
int32_t assur_ensemble_new(const assur_scene* scene, const char* const* names, size_t name_count, const double* values,
                           size_t members, size_t member_stride, const assur_options* options,
                           const assur_step_settings* settings, assur_ensemble** ensemble);
/* Replaces the table; the number of members may change. */
int32_t assur_ensemble_bind(assur_ensemble* ensemble, const double* values, size_t members, size_t member_stride);

#ifdef __cplusplus
}
#endif

#endif
