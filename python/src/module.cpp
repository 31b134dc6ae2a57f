#include "module.hpp"

#include <algorithm>
#include <exception>

namespace assur::python {
namespace {

constexpr auto kPause = std::chrono::milliseconds(50);  // between two calls of Python
constexpr int kMostSkipped = 255;

}  // namespace

py::array view(const double* data, std::vector<py::ssize_t> shape, py::handle owner, std::vector<py::ssize_t> strides) {
  if (strides.empty()) strides = py::detail::c_strides(shape, sizeof(double));
  py::array_t<double> out(std::move(shape), std::move(strides), data, owner);
  out.attr("setflags")(py::arg("write") = false);
  return out;
}

std::vector<double> numbers(const Array& array) { return {array.data(), array.data() + array.size()}; }

std::shared_ptr<py::function> shared(const py::function& function) {
  return {new py::function(function), [](py::function* of) {
            const py::gil_scoped_acquire lock;
            delete of;
          }};
}

std::string plural(std::size_t n, std::string noun) {
  if (n != 1 && noun.ends_with('y')) noun.replace(noun.size() - 1, 1, "ie");
  return std::to_string(n) + " " + noun + (n == 1 ? "" : noun.ends_with('s') ? "es" : "s");
}

Watch::Watch(const py::object& progress)
    : progress_(progress), asked_(std::chrono::steady_clock::now()), looked_(asked_) {}

Watch::~Watch() {
  try {
    if (owns_ && bar_) bar_.attr("close")();
  } catch (py::error_already_set& e) {
    e.discard_as_unraisable("assur: progress");
  }
}

void Watch::report_progress(std::int64_t done, std::int64_t of) {
  if (progress_.is_none() || done == told_) return;
  if (!bar_) {
    owns_ = !py::hasattr(progress_, "update") || PyType_Check(progress_.ptr());
    bar_ = owns_ ? progress_(py::arg("total") = of) : progress_;
    if (!owns_ && py::hasattr(bar_, "total") && bar_.attr("total").is_none()) bar_.attr("total") = of;
  }
  bar_.attr("update")(done - told_);
  told_ = done;
}

bool Watch::proceed(std::int64_t done, std::int64_t of) {
  latest_ = done;
  of_ = of;
  if (skipped_++ < to_skip_) return true;
  skipped_ = 0;
  // A look at the clock about every millisecond: it takes as long as a short step.
  const auto now = std::chrono::steady_clock::now();
  to_skip_ = now - looked_ < std::chrono::milliseconds(1) ? std::min(2 * to_skip_ + 1, kMostSkipped) : to_skip_ / 2;
  looked_ = now;
  if (now - asked_ < kPause) return true;
  const py::gil_scoped_acquire lock;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    report_progress(done, of);
  } catch (py::error_already_set& e) {
    if (e.matches(PyExc_KeyboardInterrupt)) {
      interrupted_ = true;
    } else {
      thrown_ = std::current_exception();
    }
    return false;
  }
  asked_ = looked_ = std::chrono::steady_clock::now();
  return true;
}

void Watch::finish() {
  if (thrown_) std::rethrow_exception(thrown_);
  if (!interrupted_) report_progress(latest_, of_);
}

void raise_interrupted(const py::object& result) {
  const py::object error = py::module_::import("assur._errors").attr("Interrupted")(result);
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
  throw py::error_already_set();
}

}  // namespace assur::python

PYBIND11_MODULE(_core, m) {
  using namespace assur::python;  // NOLINT
  m.doc() = "The compiled part of assur. Use the package assur.";
  m.attr("__version__") = ASSUR_VERSION;
  add_errors(m);
  add_scenes(m);
  add_builder(m);
  add_plans(m);
  add_simulators(m);
  add_jacobians(m);
  add_control_loops(m);
  add_ensembles(m);
  add_fleets(m);
  add_analysis(m);
  add_pages(m);
  add_sweeps(m);
}
