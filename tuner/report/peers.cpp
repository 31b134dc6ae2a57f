#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

#include "assur/status.hpp"
#include "output/format.hpp"
#include "report/sections.hpp"
#include "scene/names.hpp"

namespace assur::report {
namespace {

constexpr std::string_view kHead =
    "peer,mechanism,levels,steps,seconds_per_step,spread,repetitions,position_error,velocity_error,acceleration_error,"
    "comment";
constexpr std::array<std::string_view, 3> kLevels = {"position", "and velocity", "and acceleration"};

struct PeerTiming {
  std::string peer, mechanism, comment;
  int levels = 1, repetitions = 0;
  double seconds = 0, spread = 0, error = 0;  // largest of the computed levels
};

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out(1);
  for (const char c : line) c == ',' ? static_cast<void>(out.emplace_back()) : out.back().push_back(c);
  return out;
}

class Reader {
 public:
  Reader(std::istream& in, std::string file) : in_(in), file_(std::move(file)) {}

  std::vector<PeerTiming> rows() {
    std::string text;
    std::getline(in_, text);
    if (text != kHead) fail("expects the line " + std::string(kHead) + ", as bench/peers/peers.sh --csv writes it");
    std::vector<PeerTiming> out;
    while (std::getline(in_, text)) {
      ++line_;
      const std::vector<std::string> c = cells(text);
      if (c.size() < 10) fail("expects 11 columns");
      PeerTiming row{c[0], c[1], c.size() > 10 ? c[10] : ""};
      row.levels = static_cast<int>(number(c[2]));
      row.seconds = number(c[4]);
      row.spread = number(c[5]);
      row.repetitions = static_cast<int>(number(c[6]));
      if (row.levels < 1 || row.levels > 3) fail("levels are 1 to 3, not " + in_quotes(c[2]));
      if (!(row.seconds > 0)) fail("seconds_per_step is a time > 0, not " + in_quotes(c[4]));
      for (int level = 0; level < row.levels; ++level)
        row.error = std::max(row.error, number(c[7 + static_cast<std::size_t>(level)]));
      out.push_back(std::move(row));
    }
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(Error::Kind::input, {{file_ + ", line " + std::to_string(line_), what}});
  }
  double number(const std::string& text) const {
    double value = 0;
    const auto [end, trouble] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (trouble != std::errc() || end != text.data() + text.size()) fail("expects a number, not " + in_quotes(text));
    return value;
  }

  std::istream& in_;
  std::string file_;
  int line_ = 1;
};

// The fastest row of assur with the same mechanism and levels; null if there is none.
const PeerTiming* ours(const std::vector<PeerTiming>& rows, const PeerTiming& of) {
  const PeerTiming* best = nullptr;
  for (const PeerTiming& r : rows) {
    if (!r.peer.starts_with("assur") || r.mechanism != of.mechanism || r.levels != of.levels) continue;
    if (best == nullptr || r.seconds < best->seconds) best = &r;
  }
  return best;
}

}  // namespace

Section peers_section(std::istream& in, const std::string& file) {
  Section out{"peers", "Other libraries on the same mechanisms"};
  using enum HtmlTable::Column;
  HtmlTable table{
      {"mechanism", "library", "levels computed", "step", "over assur", "repetitions", "spread", "error", "how"},
      {text, text, text, number, number, number, number, number, words},
      {}};
  const std::vector<PeerTiming> rows = Reader(in, file).rows();
  for (const PeerTiming& r : rows) {
    const PeerTiming* own = ours(rows, r);
    const std::string levels(kLevels[static_cast<std::size_t>(r.levels - 1)]);
    Measurement m{r.mechanism + ", " + levels,
                  r.peer,
                  "seconds per step",
                  "s",
                  r.seconds,
                  "measured by bench/peers/peers.sh, " + file,
                  r.repetitions,
                  r.spread,
                  r.error};
    const double ratio = own != nullptr ? r.seconds / own->seconds : kNan;
    table.rows.push_back({{r.mechanism, r.peer, levels, value_text(m), own != nullptr ? output::fixed(ratio) : "-",
                           std::to_string(r.repetitions), percent(r.spread), output::error_figure(r.error), r.comment},
                          own == &r ? "strong" : ""});
    out.measurements.push_back(m);
    if (own != nullptr && own != &r) {
      out.measurements.push_back(derived(m, "time over that of assur", ratio, "ratio of the times"));
    }
  }
  out.body =
      paragraph(
          "Processor time of a step. All libraries use the same time grid, and their results are compared with the "
          "closed form. A library that computes fewer levels has less work: compare rows with the same levels.") +
      html(table);
  return out;
}

}  // namespace assur::report
