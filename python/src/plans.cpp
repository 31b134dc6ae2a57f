// Preparation, plans and the machine.
#include <pybind11/stl/filesystem.h>

#include <fstream>

#include "module.hpp"

namespace assur::python {
namespace {

PrepareOptions options_of(const std::string& strategy, const std::vector<std::string>& controlled,
                          std::optional<int> threads, const std::string& mode, double accuracy,
                          const std::vector<std::string>& without) {
  PrepareOptions out;
  out.strategy = strategy;
  out.controlled = controlled;
  if (threads) out.budget = ThreadBudget{*threads};
  if (mode != "latency" && mode != "throughput") {
    throw Error(Error::Kind::input, "mode is 'latency' or 'throughput', not '" + mode + "'");
  }
  out.mode = mode == "latency" ? Mode::latency : Mode::throughput;
  out.accuracy = accuracy;
  out.without = without;
  return out;
}

std::string text_of(const Prepared& p) {
  std::string out = "Prepared('" + p.name + "', " + plural(p.structure->groups.size(), "group") + " in " +
                    plural(p.structure->classes.size(), "class") + ":";
  for (const Plan::Choice& c : p.plan.choices) out += " " + to_string(p.plan.strategy(c));
  return out + ")";
}

}  // namespace

void add_plans(py::module_& m) {
  py::class_<Prepared>(m, "Prepared", R"(A scene that is ready to run: its structure and the plan that solves it.)")
      .def_readonly("name", &Prepared::name, "Name of the scene.")
      .def_property_readonly(
          "scene", [](const Prepared& p) { return p.scene ? std::optional(*p.scene) : std::nullopt; },
          "The Scene; None for a loaded plan.")
      .def_property_readonly(
          "time", [](const Prepared& p) { return py::make_tuple(p.time.start, p.time.end, p.time.step); },
          "The time grid: (start, end, step), s.")
      .def_readonly("controlled", &Prepared::controlled, "Names of the drivers that the program sets.")
      .def_property_readonly(
          "groups",
          [](const Prepared& p) {
            std::vector<std::string> out;
            for (std::size_t i = 0; i < p.structure->groups.size(); ++i) {
              out.push_back(p.structure->name_of(Place::group(static_cast<std::int32_t>(i))));
            }
            return out;
          },
          "Names of the structural groups, in the order in which they are solved.")
      .def_property_readonly(
          "strategies",
          [](const Prepared& p) {
            std::vector<std::string> out;
            for (const Plan::Choice& c : p.plan.choices) out.push_back(to_string(p.plan.strategy(c)));
            return out;
          },
          "The strategy of each class of groups.")
      .def_property_readonly(
          "reasons",
          [](const Prepared& p) {
            std::vector<std::string> out;
            for (const Plan::Choice& c : p.plan.choices) out.push_back(c.reason);
            return out;
          },
          "Why the plan chose each of them.")
      .def_property_readonly(
          "threads", [](const Prepared& p) { return p.plan.run.threads; }, "P, threads of the plan.")
      .def_property_readonly(
          "lanes", [](const Prepared& p) { return p.plan.lanes; },
          "W, mechanisms of an ensemble that run side by side.")
      .def(
          "save",
          [](const Prepared& p, const std::filesystem::path& file) {
            std::ofstream out(file, std::ios::binary);
            save_plan(out, p);
            out.flush();
            if (!out) throw Error(Error::Kind::environment, file.string() + " cannot be written");
          },
          py::arg("file"), "Saves the plan, which load_plan() reads without the scene.")
      .def("__repr__", [](const Prepared& p) { return text_of(p); });

  m.def(
      "prepare",
      [](const Scene& scene, const std::string& strategy, const std::vector<std::string>& controlled,
         std::optional<int> threads, const std::string& mode, double accuracy,
         const std::vector<std::string>& without) {
        const PrepareOptions options = options_of(strategy, controlled, threads, mode, accuracy, without);
        const py::gil_scoped_release release;
        return prepare(scene, options);
      },
      py::arg("scene"), py::kw_only(), py::arg("strategy") = "auto", py::arg("controlled") = std::vector<std::string>{},
      py::arg("threads") = py::none(), py::arg("mode") = "latency", py::arg("accuracy") = 0.,
      py::arg("without") = std::vector<std::string>{},
      R"(Analyses a scene, assembles its start posture, and makes a plan.

strategy: 'auto', or a text such as 'groups/lanes:8'. controlled: drivers that the program sets. threads: the largest
number (default: that of the machine). mode: 'latency' or 'throughput'. accuracy: the largest error that an output may
have; 0: as exact as doubles allow. without: backends that must not be used.
Raises InputError for an undetermined scene or a wrong option, NumericalError if the start posture cannot be assembled,
MachineError if the strategy cannot run here.)");
  m.def(
      "load_plan",
      [](const std::filesystem::path& file) {
        std::ifstream in(file, std::ios::binary);
        if (!in) throw Error(Error::Kind::environment, file.string() + " cannot be read");
        return load_plan(in);
      },
      py::arg("file"), "Loads a plan that Prepared.save() wrote.");

  py::class_<Machine>(m, "Machine", R"(The machine, as far as plans depend on it.)")
      .def_readonly("model", &Machine::model, "Name of the processor; '' if unknown.")
      .def_readonly("instructions", &Machine::instructions, "Widest set of instructions that is used, as in Highway.")
      .def_readonly("cores", &Machine::cores, "Usable physical cores: the number of one logical processor of each.")
      .def_property_readonly(
          "threads", [](const Machine& machine) { return machine.budget().threads; }, "Default number of threads.")
      .def_readonly("source", &Machine::source, "Origin of this description.")
      .def("__repr__", [](const Machine& machine) { return "Machine(" + to_string(machine) + ")"; });
  m.def("this_machine", &this_machine, "Reads the description of this machine from the system.");
  m.def(
      "backends",
      [] {
        std::map<std::string, std::string> out;
        for (const Backend& b : backends()) out[std::string(b.id)] = b.version();
        return out;
      },
      "The backends: a dict of their names and the versions of their libraries ('': not in this build).");
}

}  // namespace assur::python
