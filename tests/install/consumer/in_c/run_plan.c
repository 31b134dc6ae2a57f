/* The core alone runs a plan that another program saved. */
#include <math.h>
#include <stdio.h>

#include <assur/assur.h>

int main(int argc, char** argv) {
  assur_plan* plan = NULL;
  assur_simulator* simulator = NULL;
  assur_status status;
  size_t column = 0;
  if (argc != 2) return 2;
  if (assur_plan_load(argv[1], 1, &plan) < 0 || assur_simulator_new(plan, NULL, &simulator) < 0 ||
      assur_simulator_column(simulator, "handle1", &column) < 0 ||
      assur_simulator_step_to(simulator, 10, &status) != ASSUR_OK) {
    fprintf(stderr, "%s\n", assur_error());
    return 1;
  }
  const double angle = assur_simulator_outputs(simulator)[column];
  printf("handle1 = %.15f rad at t = %g s\n", angle, assur_simulator_time(simulator));
  assur_simulator_free(simulator);
  assur_plan_free(plan);
  return fabs(angle - 2.0782333566916) < 1e-12 ? 0 : 1; /* as in use_assur_core.cpp */
}
