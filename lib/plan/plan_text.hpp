// The tokens of a saved plan: numbers that read back exactly, "names", and labels of the next value.
//
//   assur plan 8
//   scene "four bar"
//   ...
//   checksum 0123456789abcdef
//
// One function for each type lists its fields, for writing and for reading: fields(archive, value), see
// plan_fields.hpp.
#pragma once

#include <concepts>
#include <cstdint>
#include <istream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "assur/number.hpp"

namespace assur {

// T or const T.
template <class U, class T>
concept Either = std::same_as<std::remove_const_t<U>, T>;

// Reads the rest of the stream, or only its beginning if it does not begin like a plan. Throws Error: environment if
// the stream cannot be read, input if it has more than 2 GB.
[[nodiscard]] std::string text_of_plan(std::istream& in);

class PlanWriter {
 public:
  static constexpr bool kReads = false;

  PlanWriter();

  template <class... T>
  void label(std::string_view name, const T&... values) {
    text_ += '\n';
    text_ += name;
    (*this)(values...);
  }
  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }

  // The whole text, with its checksum.
  [[nodiscard]] std::string finish();

 private:
  // Throws Error (input) for a number that is not finite.
  void put(double number);
  void put(const Number& number) { put(number.value()); }
  void put(const std::string& name);
  void put(std::int64_t number);
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void put(T number) { put(static_cast<std::int64_t>(number)); }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::int64_t>(values.size()));
    for (const T& value : values) {
      if constexpr (std::is_class_v<T>) text_ += '\n';
      put(value);
    }
  }
  template <class T>
  requires std::is_class_v<T>
  void put(const T& value) { fields(*this, value); }

  std::string text_;
};

// Reads tokens. Checks that every number is within the range of its type, and that every list has its stated length;
// the meaning of the numbers is not checked.
class PlanReader {
 public:
  static constexpr bool kReads = true;

  // Throws Error (input), like all functions here, that names the place: the text is not a saved plan, has another
  // version, or was altered.
  explicit PlanReader(std::string text);

  template <class... T>
  void label(std::string_view name, T&... values) {
    expect(name);
    (*this)(values...);
  }
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }

  // Throws Error (input) if there is text left.
  void finish();
  // Throws an Error (input) about the current line.
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  [[nodiscard]] std::string_view word();
  void expect(std::string_view name);
  [[nodiscard]] std::int64_t number(std::int64_t least, std::int64_t most);
  void get(double& number);
  void get(Number& number) {
    double value = 0;
    get(value);
    number = value;
  }
  void get(std::string& name);
  template <class T>
  requires std::is_integral_v<T>
  void get(T& value) {
    using Range = std::numeric_limits<std::conditional_t<sizeof(T) < sizeof(std::int64_t), T, std::int64_t>>;
    value = static_cast<T>(number(Range::min(), Range::max()));
  }
  template <class T>
  requires std::is_enum_v<T>
  void get(T& value) {
    std::underlying_type_t<T> underlying{};
    get(underlying);
    value = static_cast<T>(underlying);
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool there = false;
    get(there);
    if (there) get(value.emplace());
  }
  template <class T>
  void get(std::vector<T>& values) {
    const std::int64_t size = number(0, std::numeric_limits<std::int32_t>::max());
    values.clear();
    for (std::int64_t i = 0; i < size; ++i)
      get(values.emplace_back());  // grows with the text, not with the stated size
  }
  template <class T>
  requires std::is_class_v<T>
  void get(T& value) { fields(*this, value); }

  std::string text_;  // without the checksum
  std::size_t at_ = 0;
};

}  // namespace assur
