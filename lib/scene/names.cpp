#include "scene/names.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace assur {
namespace {

constexpr std::size_t kLongestName = 255;  // bytes; a choice

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_control(char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }

// Bytes of the character of UTF-8 (RFC 3629) at the front of a text that is not empty; 0: there is none.
std::size_t size_of_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0; };
  const int first = byte(0), second = byte(1);
  if (first < 0x80) return 1;
  const std::size_t size = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  // Not in more bytes than needed, no halves of UTF-16, and nothing behind U+10FFFF.
  const bool is_wrong = (first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) ||
                        (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90);
  return is_wrong ? 0 : size;
}

std::string escaped(char c) {
  if (c == '\n') return "\\n";
  if (c == '\t') return "\\t";
  if (c == '\r') return "\\r";
  constexpr std::string_view kDigits = "0123456789abcdef";
  const auto byte = static_cast<unsigned char>(c);
  return {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
}

// Number of insertions, deletions, replacements and swaps of neighbours that turn a into b, ignoring case; `limit` + 1
// if it exceeds `limit`.
std::size_t edit_distance(std::string_view a, std::string_view b, std::size_t limit) {
  if (std::max(a.size(), b.size()) - std::min(a.size(), b.size()) > limit) return limit + 1;
  std::vector<std::size_t> before, previous, row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::move(previous);
    previous = row;
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({previous[j] + 1, row[j - 1] + 1, previous[j - 1] + (same ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return std::min(row[b.size()], limit + 1);
}

std::string joined(const std::vector<std::string_view>& words, std::string_view before_last) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? before_last : ", ";
    text += words[i];
  }
  return text;
}

}  // namespace

Where Where::operator/(std::string_view key) const {
  std::string text = text_ + '/';
  for (const char c : key) {
    if (c == '~') {
      text += "~0";
    } else if (c == '/') {
      text += "~1";
    } else {
      text += c;
    }
  }
  return Where(std::move(text));
}

Where Where::operator/(std::size_t index) const { return Where(text_ + '/' + std::to_string(index)); }

const char* pose_part(std::size_t part, int dimension) {
  static constexpr const char* kSpace[] = {"x", "y", "z", "psi", "theta", "phi"};
  static constexpr const char* kPlane[] = {"x", "y", "angle"};
  return dimension == 3 ? kSpace[part] : kPlane[part];
}

bool is_name(std::string_view text) {
  return !text.empty() && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

std::string why_no_name(std::string_view text) {
  if (!is_name(text)) return in_quotes(text) + " is not a name; use letters, digits and _, and no digit first";
  return text.size() <= kLongestName ? "" : in_quotes(text) + " is too long for a name: 255 characters at most";
}

std::string near_miss(std::string_view word, const std::vector<std::string_view>& candidates) {
  if (word.size() > kLongestName) return "";  // no name; comparing takes time in proportion to both lengths
  std::size_t best = word.size() <= 1 ? 0 : word.size() <= 5 ? 1 : 2;  // typing errors that leave the word recognisable
  std::string_view found;
  for (const std::string_view candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate, best);
    if (distance > best || (distance == best && !found.empty())) continue;
    best = distance;
    found = candidate;
  }
  return std::string(found);
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates) {
  const std::string near = near_miss(word, candidates);
  return near.empty() ? "" : "; did you mean " + in_quotes(near) + "?";
}

std::string excerpt(std::string_view text) {
  // kShown bytes with any length of the text behind them are at most kLongest, so that an excerpt of an excerpt is the
  // same.
  constexpr std::size_t kLongest = 140, kShown = 100;
  std::string shown;
  std::size_t whole = 0;  // size of `shown` up to the last character that ends within kShown
  for (std::size_t i = 0; i < text.size() && shown.size() <= kLongest;) {
    const std::size_t size = size_of_character(text.substr(i));
    const bool of_two = size == 2 && text[i] == '\xc2' && text[i + 1] < '\xa0';  // U+0080 to U+009F are controls, too
    if (size == 0 || of_two || is_control(text[i])) {
      shown += escaped(text[of_two ? i + 1 : i]);
    } else {
      shown += text.substr(i, size);
    }
    i += std::max<std::size_t>(size, 1);
    if (shown.size() <= kShown) whole = shown.size();
  }
  if (shown.size() <= kLongest) return shown;
  return shown.substr(0, whole) + "... (" + std::to_string(text.size()) + " characters)";
}

std::string known_instead(std::string_view word, const std::vector<std::string_view>& candidates) {
  constexpr std::size_t kLongest = 400;  // characters
  const std::string near = suggestion(word, candidates);
  const std::string front = near.empty() ? "; there are: " : near + " There are: ";
  std::string list;
  for (const std::string_view name : candidates) {
    if (list.size() > kLongest) {
      list += ", ...";
      break;
    }
    list += (list.empty() ? front : ", ") + std::string(name);
  }
  return list;
}

std::string in_quotes(std::string_view text) { return "'" + excerpt(text) + "'"; }

std::string list_of(const std::vector<std::string_view>& words) { return joined(words, ", "); }
std::string one_of(const std::vector<std::string_view>& words) { return joined(words, " or "); }

std::string filled(std::string_view sentence, std::string_view first, std::string_view second) {
  std::string text;
  for (const std::string_view value : {first, second}) {
    const std::size_t place = sentence.find("{}");
    if (place == std::string_view::npos) break;
    text += sentence.substr(0, place);
    text += value;
    sentence.remove_prefix(place + 2);
  }
  return text += sentence;
}

std::string shortest(double number) {
  if (std::isnan(number)) return "nan";  // with or without sign
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

}  // namespace assur
