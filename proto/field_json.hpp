/// Values with field tables to JSON, and back.
///
/// Encoding: NaN, infinities and empty optionals become null; an enumeration its name; Vec2 [x, y].
/// Decoding is strict, see ObjectReader: every fault names the dotted path of its key.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/vec2.hpp"
#include "proto/field.hpp"
#include "proto/reader.hpp"

namespace ovws {

using Json = nlohmann::json;

/// Specialised for a type whose form on the wire follows from no table: encode, decode, schema.
template <class T>
struct Wire;
struct SchemaParts;  // field_schema.hpp
template <class T>
concept HasWire = requires {
  sizeof(Wire<T>);
};

namespace detail {

template <class T>
inline constexpr bool is_named_list = false;  ///< an object of keys that are data
template <class T>
inline constexpr bool is_named_list<std::vector<std::pair<std::string, T>>> = true;
template <class T>
concept TextLike = std::is_convertible_v<const T&, std::string_view>;
template <class T>
concept ListLike = requires(const T& list) {
  list.begin();
  list.end();
  list.size();
}
&&!TextLike<T>;

/// What a nullable field encodes as null; NaN and empty optionals are null in any field.
template <class T>
bool is_nothing(const T& value) {
  if constexpr (TextLike<T>) {
    return std::string_view(value).empty();
  } else if constexpr (ListLike<T> && !std::is_same_v<T, Json>) {
    return value.size() == 0;
  } else {
    return false;
  }
}

}  // namespace detail

template <class T>
Json to_json(const T& value);

/// The fields of `from` into the object `out`.
template <HasTable S>
void put_fields(Json& out, const S& from) {
  visit_fields(from, [&out](const FieldInfo& field, const auto& value) {
    out[field.key] = field.nullable && detail::is_nothing(value) ? Json() : to_json(value);
  });
}

template <class T>
Json to_json(const T& value) {
  using namespace detail;
  if constexpr (HasWire<T>) {
    return Wire<T>::to_json(value);
  } else if constexpr (std::is_same_v<T, Absent>) {
    return Json::parse(value.json);
  } else if constexpr (is_optional<T>) {
    return value ? to_json(*value) : Json();
  } else if constexpr (std::is_floating_point_v<T>) {
    return std::isfinite(value) ? Json(value) : Json();
  } else if constexpr (HasNames<T>) {
    return Names<T>::all()[std::size_t(value)];
  } else if constexpr (std::is_same_v<T, Vec2>) {
    return Json::array({to_json(value.x), to_json(value.y)});
  } else if constexpr (HasTable<T>) {
    Json out = Json::object();
    put_fields(out, value);
    return out;
  } else if constexpr (is_named_list<T>) {
    Json out = Json::object();
    for (const auto& [key, one] : value) out[key] = to_json(one);
    return out;
  } else if constexpr (std::is_same_v<T, Json> || std::is_arithmetic_v<T>) {
    return value;
  } else if constexpr (TextLike<T>) {
    return std::string(std::string_view(value));
  } else {
    static_assert(ListLike<T>, "this type has no form on the wire");
    Json out = Json::array();
    for (const auto& one : value) out.push_back(to_json(one));
    return out;
  }
}

namespace detail {

inline constexpr std::size_t kMostElements = 10000;

template <class T>
void decode_value(ObjectReader& reader, const FieldInfo& field, T& out);

/// An array of numbers, whole ones if T is an integer.
template <class T>
void decode_numbers(ObjectReader& reader, const FieldInfo& field, std::vector<T>& out) {
  std::vector<double> given;
  reader.numbers(field.key, given, field.min_size, std::min(field.max_size, kMostElements),
                 field.bounds.min, field.bounds.max);
  if (!reader.has(field.key) || reader.failed()) return;
  std::vector<T> read;
  for (const double value : given) {
    if (std::is_integral_v<T> && value != std::floor(value)) {
      return reader.fault(field.key, "must be whole numbers");
    }
    if (field.distinct && std::find(read.begin(), read.end(), T(value)) != read.end()) {
      return reader.fault(field.key, Json(T(value)).dump() + " is given twice");
    }
    read.push_back(T(value));
  }
  out = std::move(read);
}

/// A fixed number of numbers.
template <class Put>
void decode_tuple(ObjectReader& reader, const FieldInfo& field, std::size_t size, Put put) {
  std::vector<double> given;
  reader.numbers(field.key, given, size, size, field.bounds.min, field.bounds.max);
  if (given.size() == size) put(given);
}

template <HasTable S>
void decode_fields(ObjectReader& reader, S& out);

template <class T>
void decode_list(ObjectReader& reader, const FieldInfo& field, std::vector<T>& out) {
  std::vector<T> read;
  reader.objects(field.key, std::min(field.max_size, kMostElements),
                 [&read](ObjectReader& inner, std::size_t) {
                   T one{};
                   decode_fields(inner, one);
                   read.push_back(std::move(one));
                 });
  if (!reader.has(field.key) || reader.failed()) return;
  if (read.size() < field.min_size) {
    return reader.fault(field.key, "must hold " + std::to_string(field.min_size) + " at least");
  }
  out = std::move(read);
}

template <class T>
void decode_value(ObjectReader& reader, const FieldInfo& field, T& out) {
  const char* const key = field.key;
  const Bounds& bounds = field.bounds;
  if constexpr (HasWire<T>) {
    Wire<T>::decode(reader, field, out);
  } else if constexpr (std::is_same_v<T, bool>) {
    reader.boolean(key, out);
  } else if constexpr (std::is_integral_v<T>) {
    reader.integer(key, out, int(bounds.min), int(bounds.max));
  } else if constexpr (std::is_floating_point_v<T>) {
    // Null, as the value is reported where there is none, leaves it.
    std::optional<double> given;
    if (field.nullable) {
      reader.optional_number(key, given, bounds.min, bounds.max);
      out = given.value_or(out);
    } else {
      reader.number(key, out, bounds.min, bounds.max);
    }
  } else if constexpr (std::is_same_v<T, std::string>) {
    reader.string(key, out);
  } else if constexpr (HasNames<T>) {
    int value = int(out);
    reader.choice(key, value, Names<T>::all());
    out = T(value);
  } else if constexpr (std::is_same_v<T, std::optional<double>>) {
    reader.optional_number(key, out, bounds.min, bounds.max);
  } else if constexpr (std::is_same_v<T, std::optional<std::string>>) {
    reader.optional_string(key, out);
  } else if constexpr (is_optional<T>) {
    typename T::value_type given{};
    if (reader.is_null(key)) {
      reader.raw(key);
      out.reset();
    } else if (reader.has(key)) {
      decode_value(reader, field, given);
      if (!reader.failed()) out = std::move(given);
    }
  } else if constexpr (std::is_same_v<T, Vec2>) {
    decode_tuple(reader, field, 2, [&out](const auto& given) { out = {given[0], given[1]}; });
  } else if constexpr (std::is_same_v<T, std::array<double, 2>>) {
    decode_tuple(reader, field, 2, [&out](const auto& given) { out = {given[0], given[1]}; });
  } else if constexpr (HasTable<T>) {
    reader.object(key, [&out](ObjectReader& inner) { decode_fields(inner, out); });
  } else if constexpr (HasTable<typename T::value_type>) {
    decode_list(reader, field, out);
  } else {
    decode_numbers(reader, field, out);
  }
}

template <class Owner, class S, class T>
void decode_entry(ObjectReader& reader, const Field<S, T>& field, Owner& out) {
  if (field.required) reader.require(field.key);
  decode_value(reader, field, out.*field.member);
  if (field.check == nullptr || reader.failed()) return;
  if (auto wrong = field.check(out.*field.member)) reader.fault(field.key, std::move(*wrong));
}
template <class Owner, class S, class T>
void decode_entry(ObjectReader& reader, const Inlined<S, T>& entry, Owner& out) {
  decode_fields(reader, out.*entry.member);
}

template <HasTable S>
void decode_fields(ObjectReader& reader, S& out) {
  std::apply([&](const auto&... entry) { (decode_entry(reader, entry, out), ...); },
             Table<S>::kFields);
  if constexpr (requires { Table<S>::check(out, reader); }) {
    if (!reader.failed()) Table<S>::check(out, reader);
  }
}

}  // namespace detail

/// What the object says, laid over `base`; nothing on any fault (Errc::invalid).
template <HasTable S>
Result<S> decode(const Json& object, S base = {}) {
  ObjectReader reader(object, "");
  detail::decode_fields(reader, base);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return base;
}

/// A change of some of a struct's fields: what is absent stays as it is.
template <HasTable S>
class Partial {
 public:
  /// With `"clamp": true` a number out of range becomes the nearest limit. Errors as of decode; all
  /// is checked here, against a default-made S.
  static Result<Partial> decode(const Json& object);

  template <class T>
  void set(T S::*member, const T& value) {
    given_[key_of(member)] = to_json(value);
  }
  template <class T>
  bool has(T S::*member) const {
    return given_.contains(key_of(member));
  }
  bool clamp() const { return clamp_; }
  const Json& given() const { return given_; }
  S applied_to(S base) const;

 private:
  template <class T>
  static const char* key_of(T S::*member);
  static void read(ObjectReader& reader, bool clamp, S& out) {
    reader.clamp(clamp);
    detail::decode_fields(reader, out);
  }

  Json given_ = Json::object();
  bool clamp_ = false;
};

}  // namespace ovws
