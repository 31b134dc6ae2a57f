// The fuzzed functions, one for each kind of file or text that the library reads. Each one passes the bytes to the
// reader and uses the result. True if the reader accepts them; it may refuse them by assur::Error. Anything else is a
// fault: a crash, another exception, memory or time without bounds, or a result that does not pass require().
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "assur/status.hpp"

namespace assur::fuzz {

[[nodiscard]] bool scene(std::string_view bytes);     // a scene file
[[nodiscard]] bool model(std::string_view bytes);     // a model of MuJoCo, see model.cpp
[[nodiscard]] bool strategy(std::string_view bytes);  // the text of a strategy
[[nodiscard]] bool plan(std::string_view bytes);      // a saved plan, whose checksum is made to fit
[[nodiscard]] bool table(std::string_view bytes);     // a CSV table of a law
[[nodiscard]] bool variants(std::string_view bytes);  // a CSV of variants
[[nodiscard]] bool database(std::string_view bytes);  // changes to a tuning database, see database.cpp

// Throws std::logic_error, which no reader throws, if the condition is false.
inline void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(std::string("does not hold: ") + what);
}

// Calls `use`; false if it throws an Error. The Error must have a message.
template <class Use>
bool accepts(Use&& use) {
  try {
    use();
    return true;
  } catch (const Error& error) {
    require(!error.diagnostics().empty() && *error.what() != '\0', "an error has a message");
    return false;
  }
}

}  // namespace assur::fuzz
