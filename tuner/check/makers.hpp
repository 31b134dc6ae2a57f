// Scenes that no file can hold: callbacks, laws that are functions, thousands of different groups.
#pragma once

#include <string>

#include "assur/scene.hpp"
#include "check/closed_forms.hpp"

namespace assur::check {

struct Made {
  Scene scene;
  ClosedForm closed_form;  // null: the reference in quad is used
};

// Makes a scene. Throws Error (input) for an unknown maker or parameter.
[[nodiscard]] Made make(const std::string& maker, const Parameters& set);

}  // namespace assur::check
