// Pages on which a mechanism moves.
#include "module.hpp"
#include "output/format.hpp"
#include "pictures/animation.hpp"

namespace assur::python {
namespace {

constexpr std::size_t kMostFrames = 500;  // a notebook keeps the page

std::vector<double> grid_of(const TimeGrid& grid) {
  std::vector<double> times;
  const std::int64_t stride = grid.steps() / static_cast<std::int64_t>(kMostFrames) + 1;
  for (std::int64_t k = 0; k < grid.steps(); k += stride) times.push_back(grid.time(k));
  times.push_back(grid.end);
  return times;
}

// Evenly spaced ones of these times, and the last one.
std::vector<double> frames_of(const std::vector<double>& times) {
  std::vector<double> out;
  const std::size_t stride = times.size() / kMostFrames + 1;
  for (std::size_t k = 0; k + 1 < times.size(); k += stride) out.push_back(times[k]);
  if (!times.empty()) out.push_back(times.back());
  return out;
}

std::string page_of(const Ready& wanted, const std::vector<double>& times) {
  if (wanted.scene() == nullptr) {
    throw Error(Error::Kind::input, "a loaded plan has no scene to draw; prepare the scene instead");
  }
  PrepareOptions how;
  how.controlled = wanted.controlled();
  how.budget = ThreadBudget{1};
  const Scene shown = pictures::with_all_places(*wanted.scene());
  Simulator simulator(wanted.modes.empty() ? prepare(shown, how) : prepare_in_modes(shown, wanted.modes, how));
  bool interrupted = false;
  const pictures::Animation animation = run_watched(py::none(), interrupted, [&](const Observer& observer) {
    return pictures::animation_of(wanted, simulator, times, [&](std::int64_t k) {
      return !observer(k, static_cast<std::int64_t>(times.size()));
    });
  });
  const std::string from = output::number(times.front()), to = output::number(times.back());
  return animation.page({"t = " + from + " to " + to + " s; assur " ASSUR_VERSION "."});
}

std::string page_of(const Scene& scene) {
  const Structure structure = analyze(scene);
  if (!structure.cannot_assemble().empty()) {
    return pictures::Animation(scene, structure).page({"assur " ASSUR_VERSION "."});
  }
  PrepareOptions how;
  how.budget = ThreadBudget{1};
  return page_of(Ready{prepare(scene, how), {}}, grid_of(scene.time()));
}

constexpr const char* kDoc =
    "A page (HTML) on which the mechanism moves, complete in itself: for any browser, without a network. Notebooks "
    "show it.";

}  // namespace

void add_pages(py::module_& m) {
  const auto add = [&](const char* type, const auto& page) {
    const py::object cls = m.attr(type);
    cls.attr("page") = py::cpp_function(page, py::name("page"), py::is_method(cls), kDoc);
  };
  add("Scene", [](const Scene& s) { return page_of(s); });
  add("Prepared", [](const Ready& p) { return page_of(p, grid_of(p.time())); });
  add("Trajectory", [](const Motions& t) {
    if (t.rows() == 0) throw Error(Error::Kind::input, "a motion without rows cannot be drawn");
    return page_of(*t.of, frames_of(t.times()));
  });
}

}  // namespace assur::python
