/// Strict decoding of JSON objects into structs. Each fault is an Error with the dotted path of its
/// key.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

/// The name in `known` nearest to `name` by edit distance, if it is near enough for a typing error.
std::optional<std::string> nearest_name(std::string_view name,
                                        const std::vector<std::string>& known);

/// Reads one JSON object key by key. Absent keys leave the target unchanged. After the first fault
/// all reads do nothing. `finish` returns the first fault; without a fault, the first unknown key
/// with the nearest known name; else the first missing key.
///
///     ObjectReader r(json, "camera");
///     r.number("gain_db", c.gain_db, -100, 100);
///     if (auto e = r.finish(); !e) return fail(e.error());
class ObjectReader {
 public:
  /// `json` must outlive the reader. With an empty `path`, field names in errors have no prefix.
  ObjectReader(const nlohmann::json& json, std::string path);

  /// If on, a number out of range becomes the nearest limit instead of a fault.
  void clamp(bool on) { clamp_ = on; }

  bool has(const char* key) const;  ///< present (null counts as present)
  bool is_null(const char* key);    ///< marks the key as known
  void require(const char* key);    ///< a fault if absent, reported by `finish` after all others

  void number(const char* key, double& out, double min,
              double max);                                    ///< finite, min <= value <= max
  void integer(const char* key, int& out, int min, int max);  ///< whole number, min <= value <= max
  /// The same beyond 32 bits, with all digits; the limits are below 2^63.
  void integer(const char* key, std::int64_t& out, double min, double max);
  void boolean(const char* key, bool& out);
  void string(const char* key, std::string& out);
  /// Reads one of `names` and sets `out` to its index. The error suggests the nearest name.
  void choice(const char* key, int& out, const std::vector<std::string>& names);
  void numbers(const char* key, std::vector<double>& out, std::size_t min_size,
               std::size_t max_size, double min, double max);
  /// Reads a nested object: calls read(ObjectReader&) with a reader whose path includes `key`.
  /// Unknown keys of the nested object are faults, too.
  template <class Read>
  void object(const char* key, Read read);
  /// Reads an array of objects: calls read(ObjectReader&, index) for each object.
  template <class Read>
  void objects(const char* key, std::size_t max_size, Read read);
  /// Marks a key as known and returns its value, which may be JSON null, for the caller to decode.
  /// nullptr if the key is absent or a fault was found before.
  const nlohmann::json* raw(const char* key);

  void fault(std::string_view key, std::string reason);  ///< adds a fault found by the caller
  bool failed() const { return error_ || missing_; }
  Result<void> finish();

 private:
  const nlohmann::json* take(const char* key);
  std::optional<double> number_in(const std::string& field, const nlohmann::json& value, double min,
                                  double max, bool whole);
  std::string path_of(std::string_view key) const;

  const nlohmann::json& json_;
  std::string path_;
  std::vector<std::string> known_;
  std::optional<Error> error_;
  std::optional<Error>
      missing_;  ///< missing key, reported after any other fault: a misspelt key is missing, too
  bool clamp_ = false;
};

template <class Read>
void ObjectReader::object(const char* key, Read read) {
  const nlohmann::json* value = take(key);
  if (value == nullptr || error_) return;
  ObjectReader inner(*value, path_of(key));
  inner.clamp(clamp_);
  read(inner);
  if (auto done = inner.finish(); !done) error_ = done.error();
}

template <class Read>
void ObjectReader::objects(const char* key, std::size_t max_size, Read read) {
  const nlohmann::json* value = take(key);
  if (value == nullptr || error_) return;
  if (!value->is_array() || value->size() > max_size) {
    return fault(key, "must be an array of at most " + std::to_string(max_size) + " objects");
  }
  for (std::size_t i = 0; i < value->size() && !error_; ++i) {
    ObjectReader inner((*value)[i], path_of(key) + "[" + std::to_string(i) + "]");
    inner.clamp(clamp_);
    read(inner, i);
    if (auto done = inner.finish(); !done) error_ = done.error();
  }
}

}  // namespace ovws
