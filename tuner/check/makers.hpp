// Scenes that no text can say: equations of a program's own, laws that are functions, thousands of different groups.
#pragma once

#include <string>

#include "assur/scene.hpp"
#include "check/closed_forms.hpp"

namespace assur::check {

struct Made {
  Scene scene;
  ClosedForm closed_form;  // null: the reference in quad will do
};

// Throws Error (input) for a name or a parameter that is not there.
[[nodiscard]] Made make(const std::string& maker, const Parameters& set);

}  // namespace assur::check
