// Standard output of --json.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string_view>
#include <vector>

#include "assur/number.hpp"
#include "assur/status.hpp"

namespace assur {

inline void to_json(nlohmann::ordered_json& json, const Number& number) { json = number.value(); }

}  // namespace assur

namespace assur::output {

using Json = nlohmann::ordered_json;

// null if there is none; of a text, if it is empty.
template <class T>
[[nodiscard]] Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}
[[nodiscard]] inline Json or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }
template <class T>
[[nodiscard]] Json or_null(bool there, const T& value) {
  return there ? Json(value) : Json(nullptr);
}

// One object, two spaces of indentation; bytes that are no UTF-8 are replaced.
inline void print(std::ostream& out, const Json& object) {
  out << object.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

// {"error": {"kind": ..., "message": what(), "diagnostics": [{"where": ..., "what": ...}]}}
[[nodiscard]] Json to_json(const Error& error);

// [{"where": ..., "what": ...}]
[[nodiscard]] Json to_json(const std::vector<Diagnostic>& diagnostics);

}  // namespace assur::output
