// The library in the comparison, and the reference for all peers: the closed form in quad precision.
#include <cstdio>
#include <cstring>
#include <iostream>
#include <memory>
#include <utility>

#include "assur/assur.hpp"
#include "peer.hpp"
#include "references/planar.hpp"
#include "references/stewart.hpp"

namespace peers {
namespace {

bool is_planar(const std::string& mechanism) { return mechanism.starts_with("four_bar"); }

int points_of(const std::string& mechanism) {
  const std::size_t colon = mechanism.find(':');
  return is_planar(mechanism) ? (colon == std::string::npos ? 1 : std::stoi(mechanism.substr(colon + 1))) : 6;
}

// The names B1, B2, ..., each followed by `what`.
std::vector<std::string> ends(int points, const std::string& what) {
  std::vector<std::string> names;
  for (int i = 1; i <= points; ++i) names.push_back("B" + std::to_string(i) + what);
  return names;
}

// A line for each time: t, positions, velocities, accelerations.
void print_reference(const std::string& mechanism, int steps) {
  const assur::Scene scene = assur::sample(mechanism);
  const int points = points_of(mechanism);
  const std::size_t dimension = is_planar(mechanism) ? 2 : 3;
  for (int k = 0; k <= steps; ++k) {
    const double t = scene.time().time(k);
    const auto posture =
        is_planar(mechanism) ? assur::references::four_bar_chain(points, t) : assur::references::stewart(scene, t);
    std::printf("%.17g", t);
    for (int derivative = 0; derivative < 3; ++derivative) {
      for (const std::string& name : ends(points, "")) {
        for (std::size_t c = 0; c < dimension; ++c) {
          const auto& x = posture.at(name)[c];
          std::printf(" %.17g", static_cast<double>(derivative == 0   ? x.value
                                                    : derivative == 1 ? x.rate
                                                                      : x.acceleration));
        }
      }
    }
    std::printf("\n");
  }
}

class AssurPeer : public Peer {
 public:
  AssurPeer(const std::string& mechanism, int loops, int levels)
      : points_(is_planar(mechanism) ? loops : 6), levels_(levels), simulator_(prepared(mechanism)) {}

  void step(double t, Row& row) override {
    if (!simulator_.step(t).arrived()) throw std::runtime_error("the motion ends");
    const double* from = simulator_.outputs().data();
    const std::size_t n = row.position.size() / static_cast<std::size_t>(points_);
    std::vector<double>* const levels[] = {&row.position, &row.velocity, &row.acceleration};
    for (std::size_t i = 0; i < row.position.size(); i += n) {
      for (int level = 0; level < levels_; ++level, from += n) std::copy_n(from, n, levels[level]->data() + i);
    }
  }

 private:
  [[nodiscard]] assur::Prepared prepared(const std::string& mechanism) const {
    const std::string loops = is_planar(mechanism) ? ":" + std::to_string(points_) : "";
    const assur::Scene scene = assur::sample(mechanism + loops);
    return assur::prepare(scene.with_outputs(ends(points_, levels_ == 1 ? ".position" : "")),
                          {.budget = assur::ThreadBudget{1}});
  }

  int points_, levels_;
  assur::Simulator simulator_;
};

template <int levels>
std::unique_ptr<Peer> make(const std::string& mechanism, int loops, const Row&) {
  return std::make_unique<AssurPeer>(mechanism, loops, levels);
}

}  // namespace
}  // namespace peers

// `assur_peer reference MECHANISM STEPS` prints the reference. With other arguments it is a peer like the others; the
// first argument `positions` computes positions only.
int main(int argc, char** argv) {
  if (argc == 4 && std::strcmp(argv[1], "reference") == 0) {
    peers::print_reference(argv[2], std::stoi(argv[3]));
    return 0;
  }
  if (argc > 1 && std::strcmp(argv[1], "positions") == 0) {
    argv[1] = argv[0];
    return peers::run(argc - 1, argv + 1, {"assur", 1, "auto; one thread", peers::make<1>});
  }
  return peers::run(argc, argv, {"assur", 3, "auto; one thread", peers::make<3>});
}
