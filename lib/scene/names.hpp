// Names, places and texts for findings about a scene.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// A JSON pointer (RFC 6901), extended by '/': Where("/points") / "B" / "at" / 1.
class Where {
 public:
  Where() = default;
  explicit Where(std::string pointer) : text_(std::move(pointer)) {}

  [[nodiscard]] Where operator/(std::string_view key) const;  // '~' and '/' in the key are escaped
  [[nodiscard]] Where operator/(std::size_t index) const;
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// [A-Za-z_][A-Za-z0-9_]*
[[nodiscard]] bool is_name(std::string_view text);

// Name of a value of a pose, as in Simulator::set(): 3D "x", "y", "z", "psi", "theta", "phi"; 2D "x", "y", "angle".
[[nodiscard]] const char* pose_part(std::size_t part, int dimension);

// The reason why `text` is not a valid name: another form, or more than 255 characters; "" if it is valid.
[[nodiscard]] std::string why_no_name(std::string_view text);

// The candidate that `word` is most likely a misspelling of, the first one if several are equally near; "" if none is
// near.
[[nodiscard]] std::string near_miss(std::string_view word, const std::vector<std::string_view>& candidates);

// "; did you mean 'B'?", or "" if nothing is near.
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates);

// A text for use in a message; it may be untrusted. Control characters and bytes that are not UTF-8 become \n or \x1b.
// If more than 140 bytes result: the first 100 of them, and the length of the text. An excerpt of an excerpt is the
// same.
[[nodiscard]] std::string excerpt(std::string_view text);

// The end of a message about an unknown name: "; did you mean 'B'? There are: A, B" or "; there are: A, B". A long list
// is cut.
[[nodiscard]] std::string known_instead(std::string_view word, const std::vector<std::string_view>& candidates);

// 'text', as an excerpt of it
[[nodiscard]] std::string in_quotes(std::string_view text);

// a, b, c
[[nodiscard]] std::string list_of(const std::vector<std::string_view>& words);

// a, b or c
[[nodiscard]] std::string one_of(const std::vector<std::string_view>& words);

// The sentence with its first {} replaced, and its second one.
[[nodiscard]] std::string filled(std::string_view sentence, std::string_view first, std::string_view second = {});

// The shortest text that reads back as the same double.
[[nodiscard]] std::string shortest(double number);

}  // namespace assur
