#include "samples/samples.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "parallel/free_memory.hpp"
#include "scene/names.hpp"
#include "scene/scene_source.hpp"

namespace assur::samples {
namespace {

constexpr double kMany = 1e7, kMostUnknowns = 1e8;  // limits of the index type
constexpr double kBytesOfUnknown = 500;             // lower bound before preparation; four_bar takes 735

Option count(std::string_view name, double value, double least, double most, std::string_view meaning,
             std::int64_t multiple = 1) {
  return {name, meaning, value, Option::Kind::count, least, most, multiple};
}
Option real(std::string_view name, double value, double least, double most, std::string_view meaning) {
  return {name, meaning, value, Option::Kind::real, least, most};
}
Option word(std::string_view name, std::vector<std::string_view> words, std::string_view meaning) {
  return {name, meaning, 0, Option::Kind::word, 0, 0, 1, std::move(words)};
}
Option length(std::string_view name, double value, std::string_view meaning) {
  return real(name, value, 1e-9, 1e9, meaning);
}
Option omega(double value, std::string_view meaning) { return real("omega", value, 1e-9, 1e9, meaning); }
Option step(double value) { return real("step", value, 1e-12, 1e12, "time step, s"); }
Option steps(double value) { return count("steps", value, 1, 1e12, "number of time steps"); }

std::vector<SampleMechanism> make_table() {
  return {
      {"almost_parallelogram",
       "four-bar that differs from a parallelogram by delta",
       "",
       {real("delta", 1e-6, -0.75, 0.75, "length of the rocker minus that of the crank, m"), step(0.01), steps(100)},
       almost_parallelogram},
      {"andrews",
       "Andrews' squeezer, one turn of the crank in 72 steps",
       "",
       {real("xb", -0.03635, -1, 1, "x of the fixed point B, m"), omega(1, "speed of the crank, rad/s")},
       andrews},
      {"bricard",
       "Bricard's mechanism on the edges of a cube: mobility 1, one redundant equation",
       "",
       {real("middle", std::numbers::pi / 2, -7, 7, "middle of the hinge's motion, from the cube, rad"),
        real("swing", 115 * std::numbers::pi / 180, 1e-3, 7, "amplitude about the middle, rad"),
        omega(1, "speed of the motion, rad/s"), step(0.01), steps(1000)},
       bricard},
      {"four_bar",
       "crank-rocker and four-bars in series",
       "loops",
       {count("loops", 1, 1, kMany, "number of four-bars"), omega(2 * std::numbers::pi, "speed of the crank, rad/s"),
        step(0.001), steps(1000)},
       four_bar,
       [](const Values& v) { return 2 * v.plain("loops"); }},
      {"gough",
       "forward kinematics of Dietmaier's Stewart-Gough platform with 40 postures",
       "posture",
       {count("posture", 1, 1, 40, "the posture that the guess is close to")},
       gough},
      {"hexapod",
       "platform on six legs between similar hexagons",
       "",
       {word("drive", {"pose", "legs"}, "driven part; if the legs are driven, the pose is undetermined"),
        omega(1, "speed of the motion, rad/s"), step(0.01), steps(1000)},
       hexapod},
      {"jansen",
       "legs of Jansen's walking machine on one crank shaft",
       "legs",
       {count("legs", 4, 2, kMany, "number of legs", 2),
        length("La", 0.38, "distance of the pivots from the shaft, level"), length("Lb", 0.415, "pivot to top"),
        length("Lc", 0.393, "pivot to knee"), length("Ld", 0.401, "pivot to the rear of the upper triangle"),
        length("Le", 0.558, "top to the rear of the upper triangle"),
        length("Lf", 0.394, "rear of the upper triangle to shin"), length("Lg", 0.367, "knee to shin"),
        length("Lh", 0.657, "shin to foot"), length("Li", 0.49, "knee to foot"), length("Lj", 0.5, "pin to top"),
        length("Lk", 0.619, "pin to knee"), length("Ll", 0.078, "distance of the pivots below the shaft"),
        length("Lm", 0.15, "radius of the crank"), omega(std::numbers::pi, "speed of the crank, rad/s")},
       jansen,
       [](const Values& v) { return 6 * v.plain("legs"); }},
      {"n_four_bar",
       "rhombi in series, IFToMM A02 as kinematics",
       "loops",
       {count("loops", 40, 1, kMany, "number of four-bars"),
        real("swing", 1.2, -7, 7, "amplitude of the crank about the vertical, rad"), step(0.01), steps(1000)},
       n_four_bar,
       [](const Values& v) { return 2 * v.plain("loops"); }},
      {"parallelograms",
       "parallelograms in series, each with a redundant third rod",
       "loops",
       {count("loops", 3, 1, kMany, "number of parallelograms"),
        real("excess", 0, -0.5, 0.5, "excess length of the third rods, m"), omega(1, "speed of the motion, rad/s"),
        step(0.01), steps(1000)},
       parallelograms,
       [](const Values& v) { return 2 * v.plain("loops"); }},
      {"rings",
       "planar rings: one driven terminal, and legs that depend on it",
       "",
       {count("legs", 6, 1, kMany, "number of groups after the terminal"),
        count("n", 120, 12, kMany, "unknowns of each leg", 2),
        count("terminal", 24, 12, kMany, "unknowns of the terminal", 2), omega(1, "speed of the drivers, rad/s"),
        step(0.01), steps(1000)},
       rings,
       [](const Values& v) { return v.plain("legs") * v.plain("n") + v.plain("terminal"); }},
      {"scissor",
       "scissor lift, which a cylinder at its foot extends",
       "stages",
       {count("stages", 4, 1, kMany, "number of stages"), length("arm", 2, "length of the arms"),
        length("closed", 1.9, "width at the low end of the stroke"), length("open", 0.8, "width at the high end"),
        real("time", 10, 1e-9, 1e9, "time of one stroke up and down, s")},
       scissor,
       [](const Values& v) { return 4 * v.plain("stages"); }},
      {"slider_crank",
       "slider-crank, one turn per second",
       "",
       {real("crank_length", 0.1, 1e-9, 1e9, "length of the crank, m"),
        real("rod_length", 0.3, 1e-9, 1e9, "length of the rod, m"),
        real("offset", 0, -0.19, 0.19, "distance of the rail from the crank's axis, m"), step(0.001), steps(1000)},
       slider_crank},
      {"stewart",
       "the paper's Stewart platform, driven by its pose",
       "",
       {count("legs", 6, 3, kMany, "number of legs; any number other than 6 is spread evenly"),
        count("platforms", 1, 1, kMany, "number of copies, which move out of phase"),
        omega(1, "speed of the motion, rad/s"), step(0.01), steps(1000)},
       stewart,
       [](const Values& v) { return v.plain("platforms") * (15 * v.plain("legs") + 12); }},
      {"whitworth",
       "Whitworth's quick return, tilted in space",
       "",
       {real("pivot", 0.05, -10, 10, "distance of the link's pivot from the crank's axis, m"),
        word("hinge", {"implied", "stated"}, "stated: with the equation of the link's hinge, which is redundant"),
        omega(2 * std::numbers::pi, "speed of the crank, rad/s"), step(0.01), steps(1000)},
       whitworth},
  };
}

[[noreturn]] void refuse(std::string what) { throw Error(Error::Kind::input, std::move(what)); }

std::string_view name_of(std::string_view text) { return text.substr(0, text.find(':')); }

const SampleMechanism* find(std::string_view name) {
  const auto rows = table();
  const auto row = std::find_if(rows.begin(), rows.end(), [name](const SampleMechanism& s) { return s.name == name; });
  return row == rows.end() ? nullptr : &*row;
}

const SceneFile* find_file(std::string_view name) {
  const auto files = scene_files();
  const auto file = std::find_if(files.begin(), files.end(), [name](const SceneFile& f) { return f.name == name; });
  return file == files.end() ? nullptr : &*file;
}

const SampleMechanism& find_or_refuse(std::string_view name) {
  if (const SampleMechanism* row = find(name)) return *row;
  std::vector<std::string_view> names;
  for (const SampleMechanism& row : table()) names.push_back(row.name);
  for (const SceneFile& file : scene_files()) names.push_back(file.name);
  std::sort(names.begin(), names.end());
  const std::string near = suggestion(name, names);
  refuse("there is no sample " + in_quotes(name) + near + (near.empty() ? "; it" : " It") + " should be " +
         one_of(names));
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// "a multiple of 2 from 12 to 1e+07"
std::string allowed(const Option& option) {
  if (option.kind == Option::Kind::word) return one_of(option.words);
  const std::string range = " from " + shortest(option.least) + " to " + shortest(option.most);
  if (option.kind == Option::Kind::real) return "a number" + range;
  return (option.multiple == 1 ? "a whole number" : "a multiple of " + std::to_string(option.multiple)) + range;
}

bool accepts(const Option& option, const Number& value) {
  if (option.kind == Option::Kind::word || !(value >= option.least && value <= option.most)) return false;
  return option.kind == Option::Kind::real || std::fmod(value.value(), static_cast<double>(option.multiple)) == 0;
}

// Calls assign(name, value) for each item of "legs=8,omega=2".
template <class Assign, class Refuse>
void for_each_option(std::string_view text, const Assign& assign, const Refuse& refuse) {
  std::vector<std::string_view> seen;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view item = text.substr(begin, end - begin);
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos) refuse(in_quotes(item) + " should be option=value");
    const std::string_view name = item.substr(0, equals);
    if (std::find(seen.begin(), seen.end(), name) != seen.end()) refuse(in_quotes(name) + " is set twice");
    seen.push_back(name);
    assign(name, item.substr(equals + 1));
    begin = end + 1;
  }
}

// The text after the colon sets parameters of the file; `set` takes precedence.
Scene read(const SceneFile& file, std::string_view options, const Parameters& set) {
  Parameters all = set;
  const auto refuse_option = [&](const std::string& what) { refuse("sample " + in_quotes(file.name) + ": " + what); };
  if (!options.empty()) {
    for_each_option(
        options.substr(1),
        [&](std::string_view name, std::string_view text) {
          const std::optional<double> value = number(text);
          if (!value) refuse_option(in_quotes(name) + " should be a number, not " + in_quotes(text));
          all.emplace(name, *value);
        },
        refuse_option);
  }
  return parse_scene(file.text, std::string(file.name), {}, all);
}

// One call of a sample, with its options.
class Request {
 public:
  explicit Request(const SampleMechanism& row) : row_(row), values_(row.options) {}

  // Reads the text after the colon: "64", or "legs=8,omega=2".
  void read(std::string_view text) {
    if (!row_.counted.empty() && text.find('=') == std::string_view::npos) return assign(row_.counted, text);
    for_each_option(
        text, [&](std::string_view name, std::string_view value) { assign(name, value); },
        [&](const std::string& what) { refuse_with_usage(what); });
  }

  void set(std::string_view name, const Number& value) {
    const Option& option = find_option(name);
    if (!accepts(option, value)) refuse_value(option, shortest(value.value()));
    values_.set(name, value);
  }

  [[nodiscard]] std::vector<std::string> options() const {
    std::vector<std::string> names;
    for (const Option& option : row_.options) names.emplace_back(option.name);
    return names;
  }

  [[nodiscard]] Scene make() const {
    if (row_.unknowns != nullptr) check_size(row_.unknowns(values_));
    return row_.make(values_);
  }

 private:
  void check_size(double unknowns) const {
    if (unknowns > kMostUnknowns) {
      refuse("sample " + in_quotes(row_.name) + ": " + shortest(unknowns) + " unknowns are too many; the limit is " +
             shortest(kMostUnknowns));
    }
    require_memory(unknowns * kBytesOfUnknown, shortest(unknowns) + " unknowns", "ask for a smaller mechanism");
  }

  void assign(std::string_view name, std::string_view text) {
    const Option& option = find_option(name);
    const auto word = std::find(option.words.begin(), option.words.end(), text);
    if (word != option.words.end()) return values_.set(name, static_cast<double>(word - option.words.begin()));
    const std::optional<double> value = number(text);
    if (!value || !accepts(option, *value)) refuse_value(option, text);
    values_.set(name, *value);
  }

  [[nodiscard]] const Option& find_option(std::string_view name) const {
    std::vector<std::string_view> names;
    for (const Option& option : row_.options) {
      if (option.name == name) return option;
      names.push_back(option.name);
    }
    refuse_with_usage("it has no option " + in_quotes(name) + suggestion(name, names));
  }

  [[noreturn]] void refuse_value(const Option& option, std::string_view text) const {
    refuse_with_usage("option " + in_quotes(option.name) + " (" + std::string(option.meaning) + ") should be " +
                      allowed(option) + ", not " + in_quotes(text));
  }

  // Adds the sample's options and their defaults to every message.
  [[noreturn]] void refuse_with_usage(const std::string& what) const {
    std::string usage;
    for (const Option& option : row_.options) {
      (usage += usage.empty() ? "" : ",").append(option.name).append("=");
      usage += option.words.empty() ? shortest(option.value) : std::string(option.words.front());
    }
    std::string text = "sample " + in_quotes(row_.name) + ": " + what + (what.ends_with('?') ? "" : ".") + " Write ";
    if (!row_.counted.empty()) text.append(row_.name).append(":N for ").append(row_.counted).append("=N, or ");
    refuse(text.append(row_.name).append(":").append(usage).append(" or some of these options"));
  }

  const SampleMechanism& row_;
  Values values_;
};

}  // namespace

Values::Values(std::span<const Option> options) : options_(options) {
  for (const Option& option : options) value_.push_back(option.value);
}

std::string_view Values::word(std::string_view option) const {
  const std::size_t i = index(option);
  return options_[i].words[static_cast<std::size_t>(value_[i])];
}

std::size_t Values::index(std::string_view option) const {
  const auto same = [option](const Option& o) { return o.name == option; };
  return static_cast<std::size_t>(std::find_if(options_.begin(), options_.end(), same) - options_.begin());
}

std::string SceneFile::summary() const {
  std::string words;
  for (std::size_t begin = 0; text.substr(begin, 3) == "// ";) {
    const std::size_t end = text.find('\n', begin);
    words.append(words.empty() ? "" : " ").append(text.substr(begin + 3, end - begin - 3));
    begin = end + 1;
  }
  return words.substr(0, std::min({words.find(". "), words.find(": "), words.find(" (")}));
}

std::span<const SampleMechanism> table() {
  static const std::vector<SampleMechanism> rows = make_table();
  return rows;
}

}  // namespace assur::samples

namespace assur {

bool is_sample(std::string_view text) {
  const std::string_view name = samples::name_of(text);
  return samples::find(name) != nullptr || samples::find_file(name) != nullptr;
}

Scene sample(std::string_view text, const Parameters& set) {
  const std::string_view name = samples::name_of(text);
  if (const samples::SceneFile* file = samples::find_file(name)) {
    return samples::read(*file, text.substr(name.size()), set);
  }
  samples::Request request(samples::find_or_refuse(name));
  if (name.size() < text.size()) request.read(text.substr(name.size() + 1));
  for (const auto& [option, value] : set) request.set(option, value);
  return SceneSource::attach(request.make(),
                             {request.options(), [text = std::string(text), set](const Parameters& values) {
                                Parameters all = values;
                                all.insert(set.begin(), set.end());
                                return sample(text, all);
                              }});
}

}  // namespace assur
