#include "plan/plan_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "assur/status.hpp"

namespace assur {
namespace {

constexpr std::string_view kMagic = "assur plan ";
constexpr std::int64_t kVersion = 8;  // others are refused; raise it with each change of plan_fields.hpp
constexpr std::string_view kChecksum = "checksum ";
constexpr std::size_t kChecksumDigits = 16;          // of the checksum
constexpr std::size_t kPlanPiece = 1'000'000;        // bytes read at once
constexpr std::size_t kLargestPlan = 2'000'000'000;  // bytes; a million dyads take a fifth
constexpr std::string_view kSpace = " \n";

// FNV-1a, 64 bits. Every step is one-to-one in the state, so a change of a single byte is always noticed.
std::string checksum(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  std::string digits(kChecksumDigits, '0');
  for (auto d = digits.rbegin(); d != digits.rend(); ++d, hash >>= 4) *d = "0123456789abcdef"[hash & 15];
  return digits;
}

[[noreturn]] void refuse_at(std::string where, std::string what) {
  throw Error(Error::Kind::input, {{std::move(where), std::move(what)}}, "saved plan");
}

template <class T>
bool parse(std::string_view word, T& number) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc{} && end == word.data() + word.size();
}

}  // namespace

// ---- writing

PlanWriter::PlanWriter() : text_(std::string(kMagic) + std::to_string(kVersion)) {}

std::string PlanWriter::finish() {
  text_ += '\n';
  return text_ + std::string(kChecksum) + checksum(text_) + '\n';
}

void PlanWriter::put(std::int64_t number) {
  text_ += ' ';
  text_ += std::to_string(number);
}

void PlanWriter::put(double number) {
  if (!std::isfinite(number)) refuse_at("", "one of its numbers is not finite; such a plan cannot be saved");
  char digits[32];
  text_ += ' ';
  // the shortest text that reads back as the same number
  text_.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

void PlanWriter::put(const std::string& name) {
  text_ += " \"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text_ += '\\';
    text_ += c;
  }
  text_ += '"';
}

// ---- reading

std::string text_of_plan(std::istream& in) {
  std::string text;
  try {
    for (std::size_t size = in.rdbuf() != nullptr ? kPlanPiece : 0;
         size == kPlanPiece && (text.empty() || text.starts_with(kMagic));) {
      if (text.size() > kLargestPlan) {
        refuse_at("", "it is larger than " + std::to_string(kLargestPlan / 1'000'000) + " MB, the limit");
      }
      text.resize(text.size() + kPlanPiece);
      char* const end = text.data() + text.size() - kPlanPiece;
      size = static_cast<std::size_t>(std::max<std::streamsize>(in.rdbuf()->sgetn(end, kPlanPiece), 0));
      text.resize(text.size() - kPlanPiece + size);
    }
  } catch (const std::ios_base::failure& failure) {
    throw Error(Error::Kind::environment, std::string("the plan could not be read: ") + failure.code().message());
  }
  if (in.bad() || (text.empty() && in.fail())) {
    throw Error(Error::Kind::environment, "the plan could not be read: there is no such file, or it is not open");
  }
  return text;
}

PlanReader::PlanReader(std::string text) : text_(std::move(text)) {
  if (!text_.starts_with(kMagic)) {
    refuse_at("", "this is not a saved plan: it does not begin with \"" + std::string(kMagic) + "\"");
  }
  at_ = kMagic.size();
  std::int64_t version = 0;
  if (parse(word(), version) && version != kVersion) {
    refuse_at("", "its format is version " + std::to_string(version) + ", and this library reads version " +
                      std::to_string(kVersion) + "; save the plan again with this library");
  }
  const std::size_t tail = kChecksum.size() + kChecksumDigits + 1;
  const std::size_t body = text_.size() - std::min(tail, text_.size());
  const std::string_view all = text_;
  if (version != kVersion || all.substr(body) != std::string(kChecksum) + checksum(all.substr(0, body)) + '\n') {
    refuse_at("", "it is truncated or was altered (its checksum does not fit); save the plan again");
  }
  text_.resize(body);
}

void PlanReader::refuse(const std::string& what) const {
  const auto lines = std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
  refuse_at("line " + std::to_string(lines + 1), what);
}

std::string_view PlanReader::word() {
  const std::size_t begin = std::min(text_.find_first_not_of(kSpace, at_), text_.size());
  at_ = std::min(text_.find_first_of(kSpace, begin), text_.size());
  return std::string_view(text_).substr(begin, at_ - begin);
}

void PlanReader::expect(std::string_view name) {
  if (word() != name) refuse("\"" + std::string(name) + "\" was expected here");
}

std::int64_t PlanReader::number(std::int64_t least, std::int64_t most) {
  std::int64_t number = 0;
  if (!parse(word(), number) || number < least || number > most) {
    refuse("a whole number from " + std::to_string(least) + " to " + std::to_string(most) + " was expected here");
  }
  return number;
}

void PlanReader::get(double& number) {
  if (!parse(word(), number) || !std::isfinite(number)) refuse("a finite number was expected here");
}

void PlanReader::get(std::string& name) {
  name.clear();
  at_ = std::min(text_.find_first_not_of(kSpace, at_), text_.size());
  bool open = at_ < text_.size() && text_[at_] == '"';
  for (++at_; open && at_ < text_.size(); ++at_) {
    if (text_[at_] == '"') {
      ++at_;
      return;
    }
    if (text_[at_] == '\\' && ++at_ == text_.size()) break;
    name += text_[at_];
  }
  at_ = std::min(at_, text_.size());
  refuse("a name in quotes was expected here");
}

void PlanReader::finish() {
  if (!word().empty()) refuse("the end of the plan was expected here");
}

}  // namespace assur
