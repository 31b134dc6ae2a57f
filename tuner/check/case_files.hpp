// tuner/check/cases, embedded at build time.
#pragma once

#include <span>
#include <string_view>

namespace assur::check {

struct CaseFile {
  std::string_view name, text;
};

[[nodiscard]] std::span<const CaseFile> case_files();

}  // namespace assur::check
