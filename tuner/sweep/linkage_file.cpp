#include "sweep/linkage_file.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

#include "assur/status.hpp"
#include "output/hdf5.hpp"

namespace assur::sweep {

struct LinkageFile::Impl {
  using File = output::Hdf5File;
  using Type = File::Type;

  // One data set of the file, with a first dimension that grows.
  struct Column {
    const char* name;
    Type stored, given;  // in the file and in memory
    File::Shape row;     // shape of a row
  };

  std::string name;
  std::size_t joints, times;
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

  Impl(std::string file_name, const LinkageSet& set)
      : name(std::move(file_name)), joints(static_cast<std::size_t>(set.joints.most)), times(set.times.size()) {
    output::OpenHdf5* const open_file = output::load_hdf5("--out");
    const std::uint64_t j = joints;
    columns = {{"sample", Type::i64, Type::i64, {}},
               {"joints", Type::i32, Type::i32, {}},
               {"kind", Type::u8, Type::u8, {j}},
               {"left", Type::u8, Type::u8, {j}},
               {"parents", Type::u16, Type::u16, {j, 2}},
               {"values", Type::f64, Type::f64, {j, 3}},
               {"curves", set.single ? Type::f32 : Type::f64, Type::f64, {times, 2}},
               {"center", Type::f64, Type::f64, {2}},
               {"radius", Type::f64, Type::f64, {}},
               {"angle", Type::f64, Type::f64, {}},
               {"error", Type::f64, Type::f64, {}}};
    if (!set.target.empty()) columns.push_back({"distance", Type::f64, Type::f64, {}});
    std::error_code ignored;
    const bool exists = std::filesystem::exists(name, ignored);
    file.reset(open_file(exists ? File::Access::change : File::Access::create, name.c_str()));
    exists ? open(set) : create(set);
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
    check(file->add("times", Type::f64, {times}, set.times.data()));
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

  // Values of all rows, one after another.
  template <class T>
  void write(std::size_t column, std::span<const LinkageRow> all,
             const std::function<void(const LinkageRow&, T*)>& fill) {
    std::size_t each = 1;
    for (const std::uint64_t n : columns[column].row) each *= n;
    std::vector<T> values(all.size() * each);
    for (std::size_t i = 0; i < all.size(); ++i) fill(all[i], values.data() + i * each);
    const Column& c = columns[column];
    check(file->append(c.name, static_cast<std::uint64_t>(counts.rows), all.size(), c.given, values.data()));
  }

  // Values of all joints of all rows.
  template <class T>
  void write_joints(std::size_t column, std::span<const LinkageRow> all,
                    const std::function<void(const LinkageJoint&, T*)>& fill) {
    write<T>(column, all, [&](const LinkageRow& row, T* to) {
      std::size_t each = 1;
      for (std::size_t i = 1; i < columns[column].row.size(); ++i) each *= columns[column].row[i];
      for (const LinkageJoint& joint : row.linkage.joints) {
        fill(joint, to);
        to += each;
      }
    });
  }

  void append(std::span<const LinkageRow> all, const LinkageCounts& more) {
    if (!all.empty()) {
      write<std::int64_t>(0, all, [](const LinkageRow& r, auto* to) { *to = r.sample; });
      write<std::int32_t>(1, all,
                          [](const LinkageRow& r, auto* to) { *to = static_cast<int>(r.linkage.joints.size()); });
      write_joints<std::uint8_t>(2, all,
                                 [](const LinkageJoint& j, auto* to) { *to = static_cast<std::uint8_t>(j.kind); });
      write_joints<std::uint8_t>(3, all, [](const LinkageJoint& j, auto* to) { *to = j.left ? 1 : 0; });
      write_joints<std::uint16_t>(4, all, [](const LinkageJoint& j, auto* to) {
        to[0] = j.first;
        to[1] = j.second;
      });
      write_joints<double>(5, all,
                           [](const LinkageJoint& j, auto* to) { std::copy(j.value.begin(), j.value.end(), to); });
      write<double>(6, all, [](const LinkageRow& r, auto* to) {
        for (const PlanePoint& p : r.curve) to = std::copy(p.begin(), p.end(), to);
      });
      write<double>(7, all,
                    [](const LinkageRow& r, auto* to) { std::copy(r.frame.center.begin(), r.frame.center.end(), to); });
      write<double>(8, all, [](const LinkageRow& r, auto* to) { *to = r.frame.radius; });
      write<double>(9, all, [](const LinkageRow& r, auto* to) { *to = r.frame.angle; });
      write<double>(10, all, [](const LinkageRow& r, auto* to) { *to = r.error; });
      if (columns.size() > 11) write<double>(11, all, [](const LinkageRow& r, auto* to) { *to = r.distance; });
      check(file->flush());
    }
    counts.samples += more.samples;
    counts.rows += static_cast<std::int64_t>(all.size());
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
