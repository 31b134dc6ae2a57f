// Includes all headers of assur, the library for the kinematic analysis of multibody systems by group equations.
// Functions may be called by several threads at once, objects by one thread at a time, unless their comment says more.
// They are in the library assur::core, unless their comment or the head of their header names assur::assur.
#pragma once

#include "assur/backend.hpp"       // IWYU pragma: export
#include "assur/curve.hpp"         // IWYU pragma: export
#include "assur/derivatives.hpp"   // IWYU pragma: export
#include "assur/ensemble.hpp"      // IWYU pragma: export
#include "assur/fleet.hpp"         // IWYU pragma: export
#include "assur/jacobian.hpp"      // IWYU pragma: export
#include "assur/law.hpp"           // IWYU pragma: export
#include "assur/machine.hpp"       // IWYU pragma: export
#include "assur/mjcf.hpp"          // IWYU pragma: export
#include "assur/modes.hpp"         // IWYU pragma: export
#include "assur/motion_range.hpp"  // IWYU pragma: export
#include "assur/performance.hpp"
#include "assur/plan.hpp"           // IWYU pragma: export
#include "assur/print.hpp"          // IWYU pragma: export
#include "assur/report.hpp"         // IWYU pragma: export
#include "assur/rows.hpp"           // IWYU pragma: export
#include "assur/saved_plan.hpp"     // IWYU pragma: export
#include "assur/scene.hpp"          // IWYU pragma: export
#include "assur/simulator.hpp"      // IWYU pragma: export
#include "assur/status.hpp"         // IWYU pragma: export
#include "assur/step_settings.hpp"  // IWYU pragma: export
#include "assur/strategy.hpp"       // IWYU pragma: export
#include "assur/structure.hpp"      // IWYU pragma: export
#include "assur/version.hpp"        // IWYU pragma: export
