// Functions of a library that is loaded at run time.
#pragma once

#include <dlfcn.h>

#include <string>

namespace assur {

// A library stays loaded until the program ends, unless close() is called.
class SharedLibrary {
 public:
  // False if no library of this name is found.
  bool open(const char* name) {
    library_ = dlopen(name, RTLD_NOW | RTLD_LOCAL);  // a function that it lacks itself is found now, not in a call
    name_ = name;
    return library_ != nullptr;
  }
  void close() {
    if (library_) dlclose(library_);
    library_ = nullptr;
  }

  // False, and a null function, if the library that was opened last has none of this name.
  template <typename Function>
  bool find(const char* name, Function*& function) {
    function = library_ ? reinterpret_cast<Function*>(dlsym(library_, name)) : nullptr;
    if (function == nullptr) {
      if (complete_) missing_ = std::string(name_) + " has no " + name;
      complete_ = false;
    }
    return function != nullptr;
  }
  // True if every function was found.
  [[nodiscard]] bool complete() const { return complete_; }
  // The first function that was not found: "libcudart.so.13 has no cudaMalloc"; "" if complete().
  [[nodiscard]] const std::string& missing() const { return missing_; }

 private:
  void* library_ = nullptr;
  const char* name_ = "";
  bool complete_ = true;
  std::string missing_;
};

}  // namespace assur
