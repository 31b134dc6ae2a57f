// Preparation, plans and the machine.
#include <pybind11/stl/filesystem.h>

#include <fstream>

#include "module.hpp"

namespace assur::python {
namespace {

std::string text_of(const Prepared& p) {
  std::string out = "Prepared('" + p.name() + "', " + plural(p.structure().groups().size(), "group") + " in " +
                    plural(static_cast<std::size_t>(p.structure().classes()), "class") + ":";
  for (const Plan::Choice& c : p.plan().choices) out += " " + to_string(p.plan().strategy(c));
  return out + ")";
}

}  // namespace

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

std::vector<ModeChoice> choices_of(const std::map<std::string, std::size_t>& modes) {
  std::vector<ModeChoice> out;
  for (const auto& [group, mode] : modes) out.push_back({group, mode});
  return out;
}

void add_plans(py::module_& m) {
  py::class_<Ready>(m, "Prepared", R"(A scene that is ready to run: its structure and the plan that solves it.)")
      .def_property_readonly(
          "name", [](const Ready& p) { return p.name(); }, "Name of the scene.")
      .def_property_readonly(
          "scene", [](const Ready& p) { return p.scene() != nullptr ? std::optional(*p.scene()) : std::nullopt; },
          "The Scene; None for a loaded plan.")
      .def_property_readonly(
          "time", [](const Ready& p) { return py::make_tuple(p.time().start, p.time().end, p.time().step); },
          "The time grid: (start, end, step), s.")
      .def_property_readonly(
          "controlled", [](const Ready& p) { return p.controlled(); }, "Names of the drivers that the program sets.")
      .def_property_readonly(
          "groups",
          [](const Ready& p) {
            std::vector<std::string> out;
            for (Group& g : p.structure().groups()) out.push_back(std::move(g.name));
            return out;
          },
          "Names of the structural groups, in the order in which they are solved.")
      .def_property_readonly(
          "strategies",
          [](const Ready& p) {
            std::vector<std::string> out;
            for (const Plan::Choice& c : p.plan().choices) out.push_back(to_string(p.plan().strategy(c)));
            return out;
          },
          "The strategy of each class of groups.")
      .def_property_readonly(
          "reasons",
          [](const Ready& p) {
            std::vector<std::string> out;
            for (const Plan::Choice& c : p.plan().choices) out.push_back(c.reason);
            return out;
          },
          "Why the plan chose each of them.")
      .def_property_readonly(
          "threads", [](const Ready& p) { return p.plan().run.threads; }, "P, threads of the plan.")
      .def_property_readonly(
          "lanes", [](const Ready& p) { return p.plan().lanes; }, "W, mechanisms of an ensemble that run side by side.")
      .def_property_readonly(
          "expected_seconds", [](const Ready& p) { return p.plan().expected_seconds; },
          "Expected time of one step, s; 0: not predicted.")
      .def(
          "candidates",
          [](const Ready& p, std::size_t group_class) {
            if (group_class >= p.plan().choices.size()) {
              throw Error(Error::Kind::input, "there are " + plural(p.plan().choices.size(), "class") +
                                                  " of groups, and no number " + std::to_string(group_class));
            }
            const py::gil_scoped_release release;
            return candidates(p.plan().choices[group_class].shape);
          },
          py::arg("group_class") = 0,
          "All strategies for one class of groups, with their expected times: a list of Candidate, the fastest first.")
      .def(
          "rehearse",
          [](const Ready& p) {
            const py::gil_scoped_release release;
            return Ready{rehearse(p), p.modes};
          },
          "Runs the motion once; simulators of the result know the sets of redundant equations that it chose.")
      .def(
          "save",
          [](const Ready& p, const std::filesystem::path& file) {
            write_file(file, [&](std::ostream& out) { save_plan(out, p); });
          },
          py::arg("file"), "Saves the plan, which load_plan() reads without the scene.")
      .def("__repr__", [](const Ready& p) { return text_of(p); });

  m.def(
      "prepare",
      [](const Scene& scene, const std::string& strategy, const std::vector<std::string>& controlled,
         std::optional<int> threads, const std::string& mode, double accuracy, const std::vector<std::string>& without,
         const std::map<std::string, std::size_t>& modes) {
        const PrepareOptions options = options_of(strategy, controlled, threads, mode, accuracy, without);
        const std::vector<ModeChoice> chosen = choices_of(modes);
        const py::gil_scoped_release release;
        return Ready{chosen.empty() ? prepare(scene, options) : prepare_in_modes(scene, chosen, options), chosen};
      },
      py::arg("scene"), py::kw_only(), py::arg("strategy") = "auto", py::arg("controlled") = std::vector<std::string>{},
      py::arg("threads") = py::none(), py::arg("mode") = "latency", py::arg("accuracy") = 0.,
      py::arg("without") = std::vector<std::string>{}, py::arg("modes") = std::map<std::string, std::size_t>{},
      R"(Analyses a scene, assembles its start posture, and makes a plan.

strategy: 'auto', or a text such as 'groups/lanes:8'. controlled: drivers that the program sets. threads: the largest
number (default: that of the machine). mode: 'latency' or 'throughput'. accuracy: the largest error that an output may
have, relative; 0: as exact as doubles allow. without: backends that must not be used. modes: the postures in which
groups start, a dict of groups (or of points that they solve) and numbers of modes in assembly_modes().
Raises InputError for an undetermined scene or a wrong option, NumericalError if the start posture cannot be assembled,
MachineError if the strategy cannot run here.)");
  m.def(
      "load_plan",
      [](const std::filesystem::path& file) {
        std::ifstream in(file, std::ios::binary);
        if (!in) throw Error(Error::Kind::environment, file.string() + " cannot be read");
        return Ready{load_plan(in), {}};
      },
      py::arg("file"), "Loads a plan that Prepared.save() wrote.");

  py::class_<Candidate>(m, "Candidate", R"(A strategy with its expected time.)")
      .def_property_readonly(
          "strategy", [](const Candidate& c) { return to_string(c.strategy); }, "The strategy, as prepare() takes it.")
      .def_readonly("expected_seconds", &Candidate::expected_seconds,
                    "Expected time of one step of all groups of the class, s.")
      .def_readonly("factor", &Candidate::factor,
                    "With probability 2/3 the time is within this factor of the expected one; no unit.")
      .def_property_readonly(
          "origin", [](const Candidate& c) { return std::string(name(c.origin)); },
          "Evidence: 'measured', 'interpolated', 'extrapolated' or 'prior' (counts of operations).")
      .def_readonly("why_not", &Candidate::why_not, "Why it cannot run here; '': it can.")
      .def("__repr__", [](const Candidate& c) {
        return py::str("Candidate('{}', expected_seconds={:.3g}, '{}')")
            .format(to_string(c.strategy), c.expected_seconds, std::string(name(c.origin)))
            .cast<std::string>();
      });

  py::class_<PerformanceModel, std::shared_ptr<PerformanceModel>>(
      m, "PerformanceModel", R"(Predicts times of strategies from times that `assur tune` measured on this machine.)")
      .def_property_readonly("samples", &PerformanceModel::samples, "Number of measured times; 0: only counts decide.")
      .def_property_readonly("source", &PerformanceModel::source, "Description of the samples.")
      .def("__repr__",
           [](const PerformanceModel& model) { return "PerformanceModel(" + plural(model.samples(), "sample") + ")"; });
  m.def(
      "machine_model",
      [] {
        const MachineModel& known = machine_model();
        return py::make_tuple(*known.model, known.messages);
      },
      "The model by which plans are chosen on this machine, and messages about its databases: (PerformanceModel, "
      "list).");

  py::class_<Machine>(m, "Machine", R"(The machine, as far as plans depend on it.)")
      .def_readonly("model", &Machine::model, "Name of the processor; '' if unknown.")
      .def_readonly("instructions", &Machine::instructions, "Widest set of instructions that is used, as in Highway.")
      .def_readonly("cores", &Machine::cores, "Usable physical cores: the number of one logical processor of each.")
      .def_readonly("processors", &Machine::processors, "Logical processors that this process may use.")
      .def_readonly("quota", &Machine::quota,
                    "Processors that the control groups allow, e.g. 1.5; 0: no limit. A number without unit.")
      .def_property_readonly(
          "caches",
          [](const Machine& machine) {
            std::vector<std::tuple<int, std::int64_t, int>> out;
            for (const Cache& c : machine.caches) out.emplace_back(c.level, c.bytes, c.cores);
            return out;
          },
          "Caches of the first core, as (level, size in bytes, cores that share it).")
      .def_readonly("numa_nodes", &Machine::numa_nodes, "Memory nodes that the cores belong to.")
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
