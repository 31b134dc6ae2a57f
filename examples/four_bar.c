/* Moves the crank of a four-bar step by step, as a controller would, and prints the angle of its rocker.

     cc four_bar.c $(pkg-config --cflags --libs --static assur) -o four_bar && ./four_bar */
#include <stdio.h>

#include <assur/assur.h>

static int failed(const char* what) {
  fprintf(stderr, "%s: %s\n", what, assur_error());
  return 1;
}

int main(void) {
  const char* controlled[] = {"motor"};
  const char* wanted[] = {"rocker_angle"}; /* only this is computed */
  assur_options options = ASSUR_OPTIONS;
  options.controlled = controlled;
  options.controlled_count = 1;

  assur_scene* scene = NULL;
  assur_plan* plan = NULL;
  assur_simulator* simulator = NULL;
  size_t motor = 0, angle = 0;
  if (assur_scene_open("four_bar:1", &scene) < 0) return failed("scene");
  if (assur_scene_set_outputs(scene, wanted, 1) < 0) return failed("outputs");
  if (assur_prepare(scene, &options, &plan) < 0) return failed("plan");
  if (assur_simulator_new(plan, NULL, &simulator) < 0) return failed("simulator");
  if (assur_simulator_driver(simulator, "motor", &motor) < 0) return failed("driver");
  if (assur_simulator_column(simulator, "rocker_angle", &angle) < 0) return failed("column");
  assur_scene_free(scene); /* the simulator needs neither of them */
  assur_plan_free(plan);

  double slope = 0;
  if (assur_simulator_jacobian(simulator, &slope, 1, NULL, NULL) != ASSUR_OK) return failed("Jacobian");
  printf("at the start the rocker turns %.6f times as fast as the motor\n", slope);

  for (int k = 1; k <= 5; ++k) {
    assur_status status;
    if (assur_simulator_set(simulator, motor, 0.1 * k, 0, 0) < 0) return failed("target");
    if (!assur_arrived(assur_simulator_step(simulator, &status))) {
      fprintf(stderr, "stopped: %s\n", assur_code_explanation(status.code));
      return 1;
    }
    printf("motor %.1f rad, rocker %.6f rad\n", 0.1 * k, assur_simulator_outputs(simulator)[angle]);
  }
  assur_simulator_free(simulator);
  return 0;
}
