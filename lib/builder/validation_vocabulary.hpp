// The checks that rows of vocabulary.hpp ask for.
#pragma once

#include <string>

#include "builder/validation.hpp"

namespace assur {

template <class Kind>
bool Validation::check_row(const Kind& kind, const Where& where) {
  involved_.clear();
  bool differ = true;
  vocabulary::for_each_key(vocabulary::row_of<Kind>(), [&](const auto& key) {
    differ = check_content(kind, key.content, where / key.name) && differ;
  });
  return differ;
}

template <class Kind, class... Entries>
bool Validation::check_content(const Kind& kind, const vocabulary::List<Entries...>& list, const Where& where) {
  bool differ = true;
  std::size_t i = 0;
  const auto next = [&](const auto& entry) {
    differ = check_content(kind, entry, where / i++) && differ;
    if constexpr (requires { entry.about; }) differ = check_differ(entry.about, where) && differ;
  };
  std::apply([&](const auto&... entry) { (next(entry), ...); }, list.entries);
  return differ;
}

}  // namespace assur
