// Families of random mechanisms. Each draws its mechanism in a posture that satisfies all equations.
#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "mechanisms/draft.hpp"

namespace assur::mechanisms {

inline constexpr double kPi = std::numbers::pi;

inline std::string text(const char* name, std::size_t i) { return name + std::to_string(i); }
inline Place polar(double radius, double angle) { return {radius * std::cos(angle), radius * std::sin(angle), 0}; }
// A random unit vector perpendicular to n.
inline Place across(const Place& n, Draw& draw) { return unit(cross(n, draw.direction())); }

// In the plane: cranks and dyads; 3-RRR, 3-RPR and mixtures; Watt and Stephenson chains; a rod between two lines.
void planar_chain(Draft& d);
void planar_platform(Draft& d);
void six_bar(Draft& d);
void trammel(Draft& d);

// In space.
void rssr(Draft& d);
void robot(Draft& d);
void stewart(Draft& d);
void three_rps(Draft& d);
void delta(Draft& d);
void loop_in_space(Draft& d);
void bennett(Draft& d);
void cardan(Draft& d);
void wishbone(Draft& d);
void on_rails(Draft& d);

}  // namespace assur::mechanisms
