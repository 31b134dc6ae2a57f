#include "output/json.hpp"

namespace assur::output {
namespace {

const char* name(Error::Kind kind) {
  switch (kind) {
    case Error::Kind::input:
      return "input";
    case Error::Kind::numerical:
      return "numerical";
    case Error::Kind::environment:
      return "environment";
  }
  return "unknown";
}

}  // namespace

Json to_json(const Error& error) {
  return {{"error",
           {{"kind", name(error.kind())}, {"message", error.what()}, {"diagnostics", to_json(error.diagnostics())}}}};
}

Json to_json(const std::vector<Diagnostic>& diagnostics) {
  Json list = Json::array();
  for (const Diagnostic& d : diagnostics) list.push_back({{"where", d.where}, {"what", d.what}});
  return list;
}

}  // namespace assur::output
