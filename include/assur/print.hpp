// Values as text for people: std::cout << simulator.report(). Numbers are written as in the locale "C"; the text may
// change between versions. Strategies and machines have to_string().
#pragma once

#include <iosfwd>

#include "assur/ensemble.hpp"
#include "assur/jacobian.hpp"
#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/rows.hpp"
#include "assur/simulator.hpp"
#include "assur/status.hpp"

namespace assur {

// One line each, without a line break at its end.
std::ostream& operator<<(std::ostream& out, Code code);                             // its name: "fold"
std::ostream& operator<<(std::ostream& out, const Status& status);                  // code, place, figure, explanation
std::ostream& operator<<(std::ostream& out, const Event& event);                    // when, what, and where
std::ostream& operator<<(std::ostream& out, const Counters& counters);              // steps, iterations, factorisations
std::ostream& operator<<(std::ostream& out, const ErrorFigures& figures);           // residuals, and the known errors
std::ostream& operator<<(std::ostream& out, const ForwardError& error);             // against the reference
std::ostream& operator<<(std::ostream& out, const GroupFigures& figures);           // accuracy of a group
std::ostream& operator<<(std::ostream& out, const Certificate& certificate);        // what is proven
std::ostream& operator<<(std::ostream& out, const Motion& motion);                  // value, rate, acceleration
std::ostream& operator<<(std::ostream& out, const TimeGrid& grid);                  // begin, end, step
std::ostream& operator<<(std::ostream& out, const ColumnSummary& summary);          // range, mean, last
std::ostream& operator<<(std::ostream& out, const Trajectory& trajectory);          // its size, not its rows
std::ostream& operator<<(std::ostream& out, const EnsembleTrajectory& trajectory);  // the same
std::ostream& operator<<(std::ostream& out, const Ensemble::Outcome& outcome);      // the end of a member

// Several lines, each with a line break at its end.
std::ostream& operator<<(std::ostream& out, const Report& report);            // status, work, errors, events, fallbacks
std::ostream& operator<<(std::ostream& out, const Plan& plan);                // one line for each class
std::ostream& operator<<(std::ostream& out, const OutputJacobian& jacobian);  // a table with names

}  // namespace assur
