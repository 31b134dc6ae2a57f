#include "sweep/linkage_file.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <system_error>
#include <utility>

#include "assur/status.hpp"
#include "output/hdf5.hpp"

namespace assur::sweep {

struct LinkageFile::Impl {
  using File = output::Hdf5File;
  using Type = File::Type;

  using Rows = std::span<const LinkageRow>;

  // One data set of the file, with a first dimension that grows.
  struct Column {
    const char* name;
    Type stored;
    File::Shape row;                                  // shape of a row
    std::function<bool(const Column&, Rows)> append;  // false if it fails
  };

  std::string name;
  std::unique_ptr<File> file;
  std::vector<Column> columns;
  LinkageCounts counts;

  [[noreturn]] void fail() const {
    throw Error(Error::Kind::environment, {{"--out", name + " cannot be written as HDF5"}});
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(Error::Kind::input, {{"--out", name + " " + what + "; choose another file or remove it"}});
  }
  void check(bool is_done) const {
    if (!is_done) fail();
  }

  Impl(std::string file_name, const LinkageSet& set) : name(std::move(file_name)) {
    output::OpenHdf5* const open_file = output::load_hdf5("--out");
    add_columns(set);
    std::error_code ignored;
    const bool exists = std::filesystem::exists(name, ignored);
    file.reset(open_file(exists ? File::Access::change : File::Access::create, name.c_str()));
    exists ? open(set) : create(set);
  }

  // T: type of the values that `fill` writes for a row, `given` in HDF5.
  template <class T>
  void add(const char* of, Type given, File::Shape row, const std::function<void(const LinkageRow&, T*)>& fill,
           std::optional<Type> stored = {}) {
    columns.push_back({of, stored.value_or(given), std::move(row), [this, given, fill](const Column& c, Rows rows) {
                         std::size_t each = 1;
                         for (const std::uint64_t n : c.row) each *= n;
                         std::vector<T> values(rows.size() * each);
                         for (std::size_t i = 0; i < rows.size(); ++i) fill(rows[i], values.data() + i * each);
                         return file->append(c.name, static_cast<std::uint64_t>(counts.rows), rows.size(), given,
                                             values.data());
                       }});
  }
  // `each` values of every joint.
  template <class T, class Fill>
  void add_of_joints(const char* of, Type given, std::uint64_t joints, std::uint64_t each, const Fill& fill) {
    add<T>(of, given, each == 1 ? File::Shape{joints} : File::Shape{joints, each},
           [each, fill](const LinkageRow& row, T* to) {
             for (const LinkageJoint& joint : row.linkage.joints) {
               fill(joint, to);
               to += each;
             }
           });
  }

  void add_columns(const LinkageSet& set) {
    using R = LinkageRow;
    using J = LinkageJoint;
    const auto joints = static_cast<std::uint64_t>(set.joints.most);
    add<std::int64_t>("sample", Type::i64, {}, [](const R& r, auto* to) { *to = r.sample; });
    add<std::int32_t>("joints", Type::i32, {},
                      [](const R& r, auto* to) { *to = static_cast<std::int32_t>(r.linkage.joints.size()); });
    add_of_joints<std::uint8_t>("kind", Type::u8, joints, 1,
                                [](const J& j, auto* to) { *to = static_cast<std::uint8_t>(j.kind); });
    add_of_joints<std::uint8_t>("left", Type::u8, joints, 1, [](const J& j, auto* to) { *to = j.left ? 1 : 0; });
    add_of_joints<std::uint16_t>("parents", Type::u16, joints, 2, [](const J& j, auto* to) {
      to[0] = j.first;
      to[1] = j.second;
    });
    add_of_joints<double>("values", Type::f64, joints, 3,
                          [](const J& j, auto* to) { std::copy(j.value.begin(), j.value.end(), to); });
    const auto curve = [](const R& r, double* to) {
      for (const PlanePoint& p : r.curve) to = std::copy(p.begin(), p.end(), to);
    };
    add<double>("curves", Type::f64, {set.times.size(), 2}, curve, set.single ? Type::f32 : Type::f64);
    add<double>("center", Type::f64, {2},
                [](const R& r, auto* to) { std::copy(r.frame.center.begin(), r.frame.center.end(), to); });
    add<double>("radius", Type::f64, {}, [](const R& r, auto* to) { *to = r.frame.radius; });
    add<double>("angle", Type::f64, {}, [](const R& r, auto* to) { *to = r.frame.angle; });
    add<double>("error", Type::f64, {}, [](const R& r, auto* to) { *to = r.error; });
    if (!set.target.empty()) add<double>("distance", Type::f64, {}, [](const R& r, auto* to) { *to = r.distance; });
  }

  [[nodiscard]] static std::vector<std::pair<const char*, std::int64_t>> description(const LinkageSet& set) {
    return {{"seed", static_cast<std::int64_t>(set.seed)},
            {"fewest_joints", set.joints.least},
            {"most_joints", set.joints.most},
            {"first_sample", set.first},
            {"last_sample", set.last}};
  }

  [[nodiscard]] std::vector<std::pair<const char*, std::int64_t*>> figures() {
    return {{"samples", &counts.samples},
            {"rows", &counts.rows},
            {"jammed", &counts.jammed},
            {"not_closed", &counts.not_closed},
            {"inaccurate", &counts.inaccurate}};
  }

  [[nodiscard]] std::int64_t get(const char* attribute) const {
    std::int64_t value = 0;
    if (!file->get(attribute, value)) refuse("is no data set of linkages");
    return value;
  }

  // Empty if there is no such data set.
  template <class T = double>
  [[nodiscard]] std::vector<T> numbers_in(const char* of, Type type = Type::f64) const {
    if (!file->has(of)) return {};
    std::vector<T> values(file->size(of));
    check(file->read(of, type, values.data()));
    return values;
  }

  void create(const LinkageSet& set) {
    check(file != nullptr);
    for (const Column& c : columns) check(file->add_rows(c.name, c.stored, c.row));
    check(file->add("times", Type::f64, {set.times.size()}, set.times.data()));
    if (!set.target.empty()) {
      check(file->add("target", Type::f64, {set.target.size(), 2}, set.target.data()->data()));
    }
    for (const auto& [attribute, value] : description(set)) check(file->put(attribute, value));
    finish();
  }

  void open(const LinkageSet& set) {
    if (!file) refuse("is not an HDF5 file that can be continued");
    for (const auto& [attribute, value] : description(set)) {
      if (get(attribute) == value) continue;
      refuse("has " + std::string(attribute) + " " + std::to_string(get(attribute)) + ", this sweep " +
             std::to_string(value));
    }
    std::vector<double> target;
    for (const PlanePoint& p : set.target) target.insert(target.end(), p.begin(), p.end());
    if (numbers_in("times") != set.times) refuse("has other times");
    if (numbers_in("target") != target) refuse("has another target");
    for (const auto& [attribute, value] : figures()) *value = get(attribute);
    for (const Column& c : columns) {
      if (!file->has(c.name)) refuse("is no data set of linkages");
      if (!file->is(c.name, c.stored)) refuse("has another precision");
      check(file->resize(c.name, static_cast<std::uint64_t>(counts.rows)));  // drops rows after the last flush
    }
  }

  void append(Rows rows, const LinkageCounts& more) {
    if (!rows.empty()) {
      for (const Column& c : columns) check(c.append(c, rows));
      check(file->flush());  // before they count
    }
    counts.samples += more.samples;
    counts.rows += static_cast<std::int64_t>(rows.size());
    counts.jammed += more.jammed;
    counts.not_closed += more.not_closed;
    counts.inaccurate += more.inaccurate;
    finish();
  }

  // Says which rows count.
  void finish() {
    for (const auto& [attribute, value] : figures()) check(file->put(attribute, *value));
    check(file->flush());
  }
};

LinkageFile::LinkageFile(const std::string& name, const LinkageSet& set) : impl_(std::make_unique<Impl>(name, set)) {}
LinkageFile::~LinkageFile() = default;
const LinkageCounts& LinkageFile::counts() const { return impl_->counts; }
std::vector<std::pair<std::int64_t, double>> LinkageFile::distances() const {
  const std::vector<double> distances = impl_->numbers_in("distance");
  const auto samples = impl_->numbers_in<std::int64_t>("sample", Impl::Type::i64);
  std::vector<std::pair<std::int64_t, double>> all;
  for (std::size_t i = 0; i < distances.size(); ++i) all.emplace_back(samples[i], distances[i]);
  return all;
}
void LinkageFile::append(std::span<const LinkageRow> rows, const LinkageCounts& more) { impl_->append(rows, more); }

}  // namespace assur::sweep
