// The methods of a control loop as CPython calls them. The conversions of pybind11 take longer than a short step, so
// that they serve only arguments of other kinds.
#include "module.hpp"

namespace assur::python {
namespace {

// The methods of pybind11, which accept all arguments and explain wrong ones. They live as long as the module.
struct Methods {
  py::object set, step, output;
  PyTypeObject* handle = nullptr;  // of DriverHandle
};
Methods& methods() {
  static auto* const kMethods = new Methods;
  return *kMethods;
}

PyObject* call(const py::object& method, PyObject* self, PyObject* const* arguments, Py_ssize_t count,
               PyObject* names) {
  std::vector<PyObject*> all = {self};
  all.insert(all.end(), arguments, arguments + count + (names == nullptr ? 0 : PyTuple_GET_SIZE(names)));
  return PyObject_Vectorcall(method.ptr(), all.data(), static_cast<std::size_t>(count) + 1, names);
}

// Null if Python made the object without its constructor.
template <class Item>
Item* item_in(PyObject* object) {
  return reinterpret_cast<py::detail::instance*>(object)->get_value_and_holder().value_ptr<Item>();
}

// Null if it is closed or in use.
Simulator* simulator_in(PyObject* self) {
  const Session* const session = item_in<Session>(self);
  return session == nullptr ? nullptr : session->at_hand();
}

// Calls fast(), and makes its exceptions exceptions of Python.
template <class Fast>
PyObject* guarded(const Fast& fast) {
  try {
    return fast();
  } catch (const Error& e) {
    raise(e);
  } catch (py::error_already_set& e) {
    e.restore();
  } catch (const std::exception& e) {
    PyErr_SetString(PyExc_RuntimeError, e.what());
  }
  return nullptr;
}

PyObject* set(PyObject* self, PyObject* const* arguments, Py_ssize_t count, PyObject* names) {
  double numbers[3] = {0, 0, 0};  // value, rate, acceleration
  Simulator* const simulator = simulator_in(self);
  bool fast = simulator != nullptr && names == nullptr && count >= 2 && count <= 4 &&
              Py_TYPE(arguments[0]) == methods().handle && item_in<DriverHandle>(arguments[0]) != nullptr;
  for (Py_ssize_t i = 1; i < count && fast; ++i) {
    fast = PyFloat_CheckExact(arguments[i]);
    if (fast) numbers[i - 1] = PyFloat_AS_DOUBLE(arguments[i]);
  }
  if (!fast) return call(methods().set, self, arguments, count, names);
  return guarded([&] {
    simulator->set(*item_in<DriverHandle>(arguments[0]), numbers[0], numbers[1], numbers[2]);
    return py::none().release().ptr();
  });
}

PyObject* step(PyObject* self, PyObject* const* arguments, Py_ssize_t count, PyObject* names) {
  const Simulator* const simulator = simulator_in(self);
  if (simulator == nullptr || names != nullptr || count != 0 || simulator->prepared().plan().run.threads > 1) {
    return call(methods().step, self, arguments, count, names);
  }
  return guarded([&] {
    const Session::Use in_use = item_in<Session>(self)->use();  // a law may call Python
    return object_of(in_use->step()).release().ptr();
  });
}

PyObject* output(PyObject* self, PyObject* const* arguments, Py_ssize_t count, PyObject* names) {
  const Simulator* const simulator = simulator_in(self);
  if (simulator != nullptr && names == nullptr && count == 1 && PyLong_CheckExact(arguments[0])) {
    const std::size_t column = PyLong_AsSize_t(arguments[0]);
    const std::span<const double> row = simulator->outputs();
    if (column < row.size()) return PyFloat_FromDouble(row[column]);
    PyErr_Clear();
  }
  return call(methods().output, self, arguments, count, names);
}

int is_true(PyObject* object) {
  const Status* const status = item_in<Status>(object);
  if (status != nullptr) return status->arrived() ? 1 : 0;
  PyErr_SetString(PyExc_TypeError, "a Status is made by assur only");
  return -1;
}

// Replaces a method of pybind11, which it returns.
py::object replace(const py::object& type, PyMethodDef* method) {
  const py::object replaced = type.attr(method->ml_name);
  type.attr(method->ml_name) =
      py::reinterpret_steal<py::object>(PyDescr_NewMethod(reinterpret_cast<PyTypeObject*>(type.ptr()), method));
  return replaced;
}

using Function = PyObject* (*)(PyObject*, PyObject* const*, Py_ssize_t, PyObject*);
PyMethodDef method(const char* name, Function function, const char* doc) {
  return {name, reinterpret_cast<PyCFunction>(reinterpret_cast<void*>(function)), METH_FASTCALL | METH_KEYWORDS, doc};
}

}  // namespace

void add_control_loops(py::module_& m) {
  static PyMethodDef set_method = method("set", &set, R"(set($self, driver, value, rate=0.0, acceleration=0.0)
--

Sets the target of a controlled driver (a name, or a handle of driver()) for the next step; SI units.)");
  static PyMethodDef step_method = method("step", &step, R"(step($self, t=...)
--

Moves to the time t (s), or by one step of the time grid (without a grid by 1 s), and to the targets that were set.

Returns a Status, which is true if the time was reached. If it fails, step() returns to the state before it, and step(t)
stays at the last good posture; both drop their targets.)");
  static PyMethodDef output_method = method("output", &output, R"(output($self, column)
--

One output at the current time, by its name or by index(); SI units.)");
  const py::object simulator = m.attr("Simulator");
  methods() = {replace(simulator, &set_method), replace(simulator, &step_method), replace(simulator, &output_method),
               reinterpret_cast<PyTypeObject*>(m.attr("DriverHandle").ptr())};
  reinterpret_cast<PyTypeObject*>(m.attr("Status").ptr())->tp_as_number->nb_bool = &is_true;
}

}  // namespace assur::python
