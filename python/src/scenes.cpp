// Scenes and laws.
#include <pybind11/functional.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "assur/mjcf.hpp"
#include "module.hpp"

namespace assur::python {
namespace {

using Path = std::filesystem::path;

template <class Part>
std::vector<std::string> names_of(const std::vector<Part>& parts) {
  std::vector<std::string> out;
  for (const Part& p : parts) out.push_back(p.name);
  return out;
}

// Parameters from a dict and keyword arguments.
Parameters parameters_of(const Parameters& set, const py::kwargs& more) {
  Parameters out = set;
  for (const auto& [name, value] : more) out[name.cast<std::string>()] = value.cast<double>();
  return out;
}

std::string text_of(const Scene& s) {
  const TimeGrid& t = s.time();
  std::string out = "Scene('" + s.name() + "', " + (s.dimension() == 2 ? "plane" : "space") + ": " +
                    plural(s.points().size(), "point") + ", " + plural(s.bodies().size(), "body") + ", " +
                    plural(s.joints().size(), "joint") + ", " + plural(s.constraints().size(), "constraint") + ", " +
                    plural(s.drivers().size(), "driver") + "; " + plural(static_cast<std::size_t>(t.steps()), "step");
  return out + " of " + py::str(py::float_(t.step)).cast<std::string>() + " s)";
}

}  // namespace

void add_scenes(py::module_& m) {
  py::class_<Law>(m, "Law", R"(A scalar function of time, in SI units (angles in rad) and s. Laws are added with +.

A number or a sequence of coefficients c0, c1, ... stands for a law wherever one is expected.)")
      .def(py::init<>(), "The law that is 0.")
      .def(py::init([](double value) { return Law::constant(value); }), py::arg("value"), "A constant, SI units.")
      .def(py::init([](std::vector<double> c) { return Law::polynomial(std::move(c)); }), py::arg("coefficients"),
           "The polynomial c0 + c1 t + c2 t**2 + ... of the absolute time t (s); SI units.")
      .def_static(
          "polynomial", [](std::vector<double> c) { return Law::polynomial(std::move(c)); }, py::arg("coefficients"),
          "c0 + c1 t + c2 t**2 + ... of the absolute time t (s); SI units.")
      .def_static(
          "harmonic",
          [](double amplitude, double frequency, double phase, double offset) {
            return Law::harmonics({{amplitude, frequency, phase}}, offset);
          },
          py::arg("amplitude"), py::arg("frequency"), py::arg("phase") = 0., py::arg("offset") = 0.,
          "offset + amplitude * sin(2 pi frequency t + phase); frequency in Hz, phase in rad.")
      .def_static(
          "table",
          [](const Array& time, const Array& value, bool periodic, bool monotone) {
            return Law::table(numbers(time), numbers(value), periodic, monotone);
          },
          py::arg("time"), py::arg("value"), py::arg("periodic") = false, py::arg("monotone") = false,
          "A cubic spline through the points (time[i], value[i]), both arrays of (points,): s, ascending, and SI "
          "units. A monotone one does not overshoot between points, but its acceleration jumps there. Fast: no Python "
          "is called.")
      .def_static(
          "function",
          [](const py::function& motion, double tolerance) {
            return Law::function(
                [f = shared(motion)](double t) {
                  const py::gil_scoped_acquire lock;
                  const auto [value, rate, acceleration] = (*f)(t).template cast<std::tuple<double, double, double>>();
                  return Motion{value, rate, acceleration};
                },
                tolerance);
          },
          py::arg("motion"), py::arg("tolerance") = kDerivativeTolerance,
          R"(A law that motion(t) computes: it returns (value, rate, acceleration) at t (s).

Slow: each step calls Python, and threads wait for each other. The same time must give the same answer. Rate and
acceleration are compared with differences; raise `tolerance` if they are approximations.)")
      .def(
          "__add__", [](const Law& a, const Law& b) { return a + b; }, py::is_operator())
      .def(
          "__radd__", [](const Law& b, const Law& a) { return a + b; }, py::is_operator())
      .def(
          "__call__",
          [](const Law& law, double t) {
            const Motion motion = law(t);
            return py::make_tuple(motion.value, motion.rate, motion.acceleration);
          },
          py::arg("t"), "(value, rate, acceleration) at t (s); NaN outside of the range of a table.")
      .def(
          "__eq__", [](const Law& a, const Law& b) { return a == b; }, py::is_operator())
      .def("__repr__", [](const Law& law) { return "Law(" + plural(law.parts().size(), "part") + ")"; });
  py::implicitly_convertible<py::float_, Law>();
  py::implicitly_convertible<py::int_, Law>();
  py::implicitly_convertible<py::sequence, Law>();

  py::class_<Scene>(m, "Scene", R"(A mechanism with drivers, measures, outputs and a time grid; it does not change.

Made by scene(), sample(), read_scene(), parse_scene() or SceneBuilder. Lengths in m, angles in rad, times in s.)")
      .def_property_readonly("name", &Scene::name, "Name of the scene.")
      .def_property_readonly("dimension", &Scene::dimension, "2: in the plane, 3: in space.")
      .def_property_readonly(
          "points", [](const Scene& s) { return names_of(s.points()); },
          "Names of all points except members of bodies.")
      .def_property_readonly(
          "bodies", [](const Scene& s) { return names_of(s.bodies()); }, "Names of the bodies.")
      .def_property_readonly(
          "joints", [](const Scene& s) { return names_of(s.joints()); }, "Names of the joints.")
      .def_property_readonly(
          "constraints", [](const Scene& s) { return names_of(s.constraints()); },
          "Names of the constraints, those of joints included.")
      .def_property_readonly(
          "drivers", [](const Scene& s) { return names_of(s.drivers()); }, "Names of the drivers.")
      .def_property_readonly(
          "measures", [](const Scene& s) { return names_of(s.measures()); }, "Names of the measures.")
      .def_property_readonly("outputs", &Scene::outputs, "Names of the wanted outputs; empty: everything that moves.")
      .def_property_readonly("parameters", &Scene::parameters,
                             "Names of the parameters of a file, or of the options of a sample.")
      .def_property_readonly(
          "time", [](const Scene& s) { return py::make_tuple(s.time().start, s.time().end, s.time().step); },
          "The time grid: (start, end, step), s.")
      .def_property_readonly(
          "warnings",
          [](const Scene& s) {
            py::list out;
            for (const Diagnostic& d : s.warnings()) out.append(py::make_tuple(d.where, d.what));
            return out;
          },
          "Findings that are no errors, as pairs (where, what).")
      .def(
          "with_outputs",
          [](const Scene& s, const py::args& outputs) {
            std::vector<std::string> names;
            for (const py::handle& o : outputs) names.push_back(o.cast<std::string>());
            return s.with_outputs(std::move(names));
          },
          "The same mechanism with these outputs: 'C', 'C.velocity', 'C.vx', a measure, a body, or 'all' alone.")
      .def(
          "with_time",
          [](const Scene& s, double start, double end, double step) {
            return s.with_time({start, end, step});
          },
          py::arg("start"), py::arg("end"), py::arg("step"),
          "The same mechanism with this time grid, s: a whole number of steps.")
      .def(
          "with_values",
          [](const Scene& s, const Parameters& values, const py::kwargs& more) {
            return s.with_values(parameters_of(values, more));
          },
          py::arg("values") = Parameters{},
          "The same mechanism with other values of parameters, or of numbers as written: 'P.x' of a point, 'C' of a "
          "constraint (SI units).")
      .def(
          "with_laws",
          [](const Scene& s, const std::map<std::string, Law>& laws) {
            std::map<std::string, bool> used;
            for (const auto& [driver, law] : laws) used[driver] = false;
            Scene out = s.with_laws([&](const std::string& driver, const Law& before) {
              const auto of = laws.find(driver);
              if (of == laws.end()) return before;
              used[driver] = true;
              return of->second;
            });
            for (const auto& [driver, is_used] : used) {
              if (!is_used) throw Error(Error::Kind::input, "the scene has no driver '" + driver + "'");
            }
            return out;
          },
          py::arg("laws"),
          "The same mechanism with other laws: a dict of drivers (of a pose 'pose.x', ...) and laws, rad or m.")
      .def(
          "to_json", [](const Scene& s) { return write_scene(s); }, "The scene as text of a scene file.")
      .def(
          "write", [](const Scene& s, const Path& file) { write_scene(s, file); }, py::arg("file"),
          "Writes the scene to a file, which it replaces.")
      .def("__repr__", [](const Scene& s) { return text_of(s); });

  const auto no_folders = std::vector<Path>{};
  m.def(
      "scene",
      [](const py::object& what, const Parameters& set, const std::vector<Path>& folders, const py::kwargs& more) {
        return open_scene(py::str(what).cast<std::string>(), parameters_of(set, more), folders);
      },
      py::arg("what"), py::arg("set") = Parameters{}, py::arg("folders") = no_folders,
      R"(Opens a scene file (.json), a model of MuJoCo (.xml), or a sample: scene('stewart:legs=8', omega=2).

Keyword arguments, or the dict `set`, replace parameters, in their units in the file. `folders`: where tables may lie
besides the folder of the file. Raises MachineError if the file cannot be read, InputError with every finding if it is
wrong.)");
  m.def(
      "sample",
      [](const std::string& text, const Parameters& set, const py::kwargs& more) {
        return sample(text, parameters_of(set, more));
      },
      py::arg("text"), py::arg("set") = Parameters{},
      "Makes a sample mechanism: 'stewart', 'four_bar:64', ... Options as in the text, SI units.");
  m.def(
      "read_scene",
      [](const Path& file, const Parameters& set, const std::vector<Path>& folders) {
        return read_scene(file, set, folders);
      },
      py::arg("file"), py::arg("set") = Parameters{}, py::arg("folders") = no_folders,
      "Reads a scene file (JSON). `set` replaces parameters, in their units in the file.");
  m.def(
      "parse_scene",
      [](const py::object& content, const std::string& name, const Path& folder, const Parameters& set) {
        const py::object text =
            py::isinstance<py::str>(content) ? content : py::module_::import("json").attr("dumps")(content);
        return parse_scene(text.cast<std::string>(), name, folder, set);
      },
      py::arg("content"), py::arg("name") = "scene", py::arg("folder") = Path("."), py::arg("set") = Parameters{},
      "Reads a scene from text, or from a dict with the same sections as a scene file (docs/scenes.md). `set` replaces "
      "parameters, in their units there.");

  using Model = ImportedModel;
  py::class_<Model>(m, "ImportedModel", R"(A model of MuJoCo as a scene (docs/mjcf.md).)")
      .def_readonly("name", &Model::name, "Name of the model.")
      .def_readonly("scene", &Model::scene, "The Scene.")
      .def_property_readonly(
          "coordinates",
          [](const Model& model) {
            std::map<std::string, std::tuple<std::string, double, bool>> out;
            for (const Model::Coordinate& c : model.coordinates) out[c.joint] = {c.name, c.start, c.driven};
            return out;
          },
          "A dict of joints and (name in the scene, value of MuJoCo at the posture as written, True if it is driven); "
          "rad or m.")
      .def_property_readonly(
          "drivers",
          [](const Model& model) {
            std::map<std::string, std::tuple<std::string, bool>> out;
            for (const Model::Driver& d : model.drivers) out[d.name] = {d.coordinate, d.controlled};
            return out;
          },
          "A dict of drivers and (coordinate, True if it stands still unless the program sets it).")
      .def_readonly("loops", &Model::loops, "Number of loops that equalities close.")
      .def_property_readonly(
          "left_out",
          [](const Model& model) {
            return std::map<std::string, std::size_t>(model.left_out.begin(), model.left_out.end());
          },
          "Kinds of elements without a meaning here, and their numbers.")
      .def_readonly("notes", &Model::notes, "Sentences: names that were changed, loops that had to be closed.")
      .def("__repr__", [](const Model& model) {
        return "ImportedModel('" + model.name + "', " + plural(model.joints, "joint") + ", " +
               plural(model.loops, "loop") + ")";
      });
  m.def(
      "import_model",
      [](const Path& file, const std::string& key, const std::map<std::string, std::string>& drive,
         const std::vector<Path>& folders) {
        return import_model(file, {key, {drive.begin(), drive.end()}, folders});
      },
      py::arg("file"), py::arg("key") = "", py::arg("drive") = std::map<std::string, std::string>{},
      py::arg("folders") = no_folders,
      R"(Reads a model of MuJoCo (.xml) as an ImportedModel.

key: the keyframe at which the motion starts. drive: a dict of joints and laws, rad or m, as text: '0,6.28'
(coefficients of a polynomial of time), a law of a scene file, or 'free'. folders: where tables of laws may lie.)");
}

}  // namespace assur::python
