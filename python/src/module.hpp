// Parts of the Python module assur._core.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "assur/curve.hpp"
#include "assur/modes.hpp"

// A Number is a float.
template <>
struct pybind11::detail::type_caster<assur::Number> {
  PYBIND11_TYPE_CASTER(assur::Number, const_name("float"));
  bool load(handle from, bool convert) {
    make_caster<double> number;
    if (!number.load(from, convert)) return false;
    value = cast_op<double>(number);
    return true;
  }
  static handle cast(const assur::Number& from, return_value_policy, handle) {
    return PyFloat_FromDouble(from.value());
  }
};

namespace assur::python {

namespace py = pybind11;

// Numbers of an argument, contiguous; other types of numbers are converted.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

void add_errors(py::module_& m);
void add_scenes(py::module_& m);
void add_builder(py::module_& m);
void add_plans(py::module_& m);
void add_simulators(py::module_& m);
void add_jacobians(py::module_& m);
void add_ensembles(py::module_& m);
void add_fleets(py::module_& m);
void add_analysis(py::module_& m);
void add_control_loops(py::module_& m);
void add_pages(py::module_& m);
void add_sweeps(py::module_& m);

// Prepared with the modes in which its motion starts, so that it can be prepared again.
struct Ready : Prepared {
  std::vector<ModeChoice> modes;
};

// A trajectory with its mechanism, and with the report of its run.
struct Motions : Trajectory {
  std::shared_ptr<const Ready> of;
  Report report;
};

// An object that changes and serves one call at a time, until it is closed. A call that comes meanwhile, from another
// thread or from a function that the first call calls, is refused: if it waited, the function would wait for ever. The
// lock of the interpreter guards the flag.
template <class Object>
class Exclusive {
 public:
  // The object for as long as this lives.
  class Use {
   public:
    explicit Use(const Exclusive& of) : of_(of) { of_.in_use_ = true; }
    ~Use() { of_.in_use_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    Object& operator*() const { return *of_.object_; }
    Object* operator->() const { return of_.object_.get(); }

   private:
    const Exclusive& of_;
  };

  // noun, name: of the object, for messages.
  Exclusive(std::unique_ptr<Object> object, const char* noun, std::string name)
      : object_(std::move(object)), noun_(noun), name_(std::move(name)) {}

  // Throws Error (input) if the object is closed or in use.
  [[nodiscard]] Use use() const {
    check_free();
    (void)constant();
    return Use(*this);
  }
  // The object for parts that no call changes. Throws Error (input) if it is closed.
  [[nodiscard]] const Object& constant() const {
    if (!object_) throw Error(Error::Kind::input, std::string("the ") + noun_ + " is closed; make another one");
    return *object_;
  }
  // The object if it can be used; null if use() throws.
  [[nodiscard]] Object* at_hand() const { return in_use_ ? nullptr : object_.get(); }
  // Ends threads and returns memory, but for the memory that arrays show. Throws Error (input) if it is in use.
  void close() {
    check_free();
    object_.reset();
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  // Shares the object with an array that shows its memory.
  [[nodiscard]] std::shared_ptr<Object> shared() const { return object_; }
  // "closed" or "in use"; "": it can be used.
  [[nodiscard]] const char* state() const { return in_use_ ? "in use" : object_ ? "" : "closed"; }

 private:
  void check_free() const {
    if (!in_use_) return;
    const std::string noun = noun_;
    throw Error(Error::Kind::input, "the " + noun + " of '" + name_ +
                                        "' is in use, by a call of another thread or by the call that called this "
                                        "function; make one " +
                                        noun + " for each thread, and one for the function");
  }

  std::shared_ptr<Object> object_;
  const char* noun_;
  std::string name_;
  mutable bool in_use_ = false;
};

// Calls work(). Threads of the plan may have to call Python: if there are any, this thread gives them the lock of the
// interpreter.
template <class Work>
auto with_threads(const Plan& plan, const Work& work) {
  std::optional<py::gil_scoped_release> release;
  if (plan.run.threads > 1) release.emplace();
  return work();
}

// A simulator.
struct Session : Exclusive<Simulator> {
  explicit Session(const Ready& prepared, const StepSettings& settings = {});
  // Calls work(simulator).
  template <class Work>
  auto call(const Work& work) const {
    const Use simulator = use();
    return with_threads(simulator->prepared().plan(), [&] { return work(*simulator); });
  }

  std::vector<ModeChoice> modes;
};

// An array that shows memory of `owner`, which it keeps alive; not writable. strides: bytes; empty: contiguous.
py::array view(const double* data, std::vector<py::ssize_t> shape, py::handle owner,
               std::vector<py::ssize_t> strides = {});
// A curve, an array of (points, 2). Throws Error (input) for another shape.
std::vector<PlanePoint> curve_of(const Array& points);
// The numbers of an array, row after row.
std::vector<double> numbers(const Array& array);
// Writes a file by write(stream). Throws Error (environment) if this fails.
template <class Write>
void write_file(const std::string& file, const Write& write) {
  std::ofstream out(file, std::ios::binary);
  write(out);
  out.flush();
  if (!out) throw Error(Error::Kind::environment, file + " cannot be written");
}
// Success is one object: making another one takes as long as a short step.
py::object object_of(const Status& status);
// None for NaN.
py::object known(double figure);
// Raises the exception of the package for an Error.
void raise(const Error& e);
// A function of the program, which is released under the lock of the interpreter.
std::shared_ptr<py::function> shared(const py::function& function);

// Calls back into Python during long calls: progress, and Ctrl-C. Only proceed() is called without the lock of the
// interpreter.
class Watch {
 public:
  // progress: None; an object with update(n), as of tqdm; or a function that makes one of `total`.
  explicit Watch(const py::object& progress);
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  // At most every 50 ms, tells how much is done. False if Python wants to stop.
  bool proceed(std::int64_t done, std::int64_t of);
  // True if Ctrl-C stopped the call.
  [[nodiscard]] bool interrupted() const { return interrupted_; }
  // Throws what a function of the program threw.
  void finish();

 private:
  void report_progress(std::int64_t done, std::int64_t of);

  py::object progress_, bar_;
  std::int64_t told_ = 0, latest_ = 0, of_ = 0;
  std::chrono::steady_clock::time_point asked_, looked_;  // when Python was called, when the clock was read
  int skipped_ = 0, to_skip_ = 0;                         // calls without a look at the clock
  bool interrupted_ = false, owns_ = false;
  std::exception_ptr thrown_;
};

// Calls run(observer) without the lock of the interpreter, and returns its result; `interrupted`: Ctrl-C stopped it.
template <class Run>
auto run_watched(const py::object& progress, bool& interrupted, const Run& run) {
  Watch watch(progress);
  auto result = [&] {
    const py::gil_scoped_release release;
    return run([&](std::int64_t done, std::int64_t of) { return !watch.proceed(done, of); });
  }();
  watch.finish();
  interrupted = watch.interrupted();
  return result;
}

// Keyword arguments of prepare(); `threads`: None for the default.
PrepareOptions options_of(const std::string& strategy, const std::vector<std::string>& controlled,
                          std::optional<int> threads, const std::string& mode, double accuracy,
                          const std::vector<std::string>& without);

// A dict of groups and numbers of modes.
std::vector<ModeChoice> choices_of(const std::map<std::string, std::size_t>& modes);

// Gives rows to a function of Python: (t, values), with_member: (member, t, values). Any thread may call it.
RowSink row_sink(const py::function& callback, bool with_member);

// Raises assur.Interrupted, whose `result` is this object.
[[noreturn]] void raise_interrupted(const py::object& result);

// "1 row", "2 rows", "2 bodies", "2 classes"
std::string plural(std::size_t n, std::string noun);

}  // namespace assur::python
