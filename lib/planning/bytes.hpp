// Plain values as bytes and back, for one machine and one build.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace assur {

template <class T>
concept Plain = std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>;

// Other types have write(ByteWriter&) and read(ByteReader&).
class ByteWriter {
 public:
  template <class T>
  void put(const T& value) {
    if constexpr (Plain<T>) {
      put_all(&value, 1);
    } else {
      value.write(*this);
    }
  }
  // Elements without bytes that mean nothing: `T` has numbers of 4 or 8 bytes only, and no gaps.
  template <class T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    put_all(values.data(), values.size());
  }
  void put(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    put_all(text.data(), text.size());
  }
  template <class Key, class Value>
  void put(const std::map<Key, Value>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    for (const auto& [key, value] : values) {
      put(key);
      put(value);
    }
  }

  [[nodiscard]] std::vector<std::byte> take() && { return std::move(bytes_); }

 private:
  template <class T>
  void put_all(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* from = reinterpret_cast<const std::byte*>(values);
    bytes_.insert(bytes_.end(), from, from + count * sizeof(T));
  }

  std::vector<std::byte> bytes_;
};

// What is not there is read as nothing, and whole() is false from then on.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : left_(bytes) {}

  template <class T>
  void get(T& value) {
    if constexpr (Plain<T>) {
      get_all(&value, 1);
    } else {
      value.read(*this);
    }
  }
  template <class T>
  void get(std::vector<T>& values) {
    values.resize(count_of(sizeof(T)));
    get_all(values.data(), values.size());
  }
  void get(std::string& text) {
    text.resize(count_of(1));
    get_all(text.data(), text.size());
  }
  template <class Key, class Value>
  void get(std::map<Key, Value>& values) {
    for (std::size_t left = count_of(1); left > 0 && !failed_; --left) {
      Key key{};
      Value value{};
      get(key);
      get(value);
      values.emplace_hint(values.end(), std::move(key), std::move(value));
    }
  }

  // Everything was there, and nothing is left over.
  [[nodiscard]] bool whole() const { return !failed_ && left_.empty(); }

 private:
  // Of elements that follow; never more than there are bytes for.
  std::size_t count_of(std::size_t size) {
    std::uint64_t count = 0;
    get(count);
    if (count <= left_.size() / size) return static_cast<std::size_t>(count);
    failed_ = true;
    return 0;
  }
  template <class T>
  void get_all(T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    failed_ = failed_ || left_.size() < count * sizeof(T);
    if (failed_ || count == 0) return;
    std::memcpy(values, left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
  }

  std::span<const std::byte> left_;
  bool failed_ = false;
};

}  // namespace assur
