// Samples: mechanisms named by a text: "stewart", "four_bar:64", "rings:legs=6,n=120,terminal=24". A sample is one row
// of the table in samples.cpp and one function in samples/, or a file in scenes/, whose text is part of the library.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/scene.hpp"

namespace assur::samples {

// An option, which is set in the text ("stewart:legs=8") or as a parameter; the parameter takes precedence.
struct Option {
  enum class Kind : std::uint8_t { count, real, word };

  std::string_view name;
  std::string_view meaning;
  double value = 0;  // default; for a word its position in `words`
  Kind kind = Kind::real;
  double least = 0, most = 0;  // allowed, both included
  std::int64_t multiple = 1;   // a count is a multiple of this
  std::vector<std::string_view> words = {};
};

// The options of one call.
class Values {
 public:
  explicit Values(std::span<const Option> options);

  [[nodiscard]] const Number& operator[](std::string_view option) const { return value_[index(option)]; }
  // Without its origin: mechanisms of a table have the time grid of the first one.
  [[nodiscard]] double plain(std::string_view option) const { return value_[index(option)].value(); }
  [[nodiscard]] int count(std::string_view option) const { return static_cast<int>(double{value_[index(option)]}); }
  [[nodiscard]] std::string_view word(std::string_view option) const;

  void set(std::string_view option, const Number& value) { value_[index(option)] = value; }

 private:
  [[nodiscard]] std::size_t index(std::string_view option) const;

  std::span<const Option> options_;
  std::vector<Number> value_;
};

struct SampleMechanism {
  std::string_view name;
  std::string_view summary;
  std::string_view counted;  // the option that a bare number sets: 64 of "four_bar:64"; "" if there is none
  std::vector<Option> options;
  Scene (*make)(const Values&);
  double (*unknowns)(const Values&) = nullptr;  // approximate number; for samples that may be large
};

// Every sample, in alphabetic order.
[[nodiscard]] std::span<const SampleMechanism> table();

// A scene file of scenes/; its parameters are the options.
struct SceneFile {
  std::string_view name, text;

  [[nodiscard]] std::string summary() const;  // the begin of its comment
};

// Every file in scenes/ whose name is not in table(), in alphabetic order. CMake writes it.
[[nodiscard]] std::span<const SceneFile> scene_files();

// One function for each row; each definition explains its geometry.
Scene almost_parallelogram(const Values&);
Scene andrews(const Values&);
Scene bricard(const Values&);
Scene four_bar(const Values&);
Scene gough(const Values&);
Scene hexapod(const Values&);
Scene jansen(const Values&);
Scene n_four_bar(const Values&);
Scene parallelograms(const Values&);
Scene rings(const Values&);
Scene scissor(const Values&);
Scene slider_crank(const Values&);
Scene stewart(const Values&);
Scene whitworth(const Values&);

}  // namespace assur::samples
