#include "proto/encode.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/base/pixels.hpp"
#include "proto/json_text.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {
namespace {

static_assert(std::endian::native == std::endian::little, "binary parts are little-endian");

/// Writes the fields of a table as one flat JSON object into a string that the caller reuses, so
/// that nothing is allocated once the string has grown. Texts are our own names and need no
/// escaping.
class ObjectWriter {
 public:
  explicit ObjectWriter(std::string& out) : out_(out) { out_.clear(); }

  template <HasTable S>
  void write(const S& message) {
    visit_fields(message, [this](const FieldInfo& field, const auto& value) {
      out_.append(out_.empty() ? "{\"" : ",\"").append(field.key).append("\":");
      put(value);
    });
    out_.push_back('}');
  }

 private:
  template <class T>
  void put(const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      out_.append(value ? "true" : "false");
    } else if constexpr (std::is_arithmetic_v<T>) {
      put_number(value);
    } else if constexpr (std::is_enum_v<T>) {
      put(wire_name(value));
    } else if constexpr (std::is_convertible_v<T, std::string_view>) {
      out_.append(1, '"').append(value).append(1, '"');
    } else if constexpr (detail::is_optional<T>) {
      value ? put(*value) : null();
    } else {
      put_all(value);
    }
  }
  template <class T>
  void put_all(const NumbersOrNull<T>& numbers) {
    put_each(numbers.values, [this, &numbers](T value) { numbers.valid ? put(value) : null(); });
  }
  template <class List>
  void put_all(const List& values) {
    put_each(values, [this](const auto& value) { this->put(value); });
  }
  template <class List, class Put>
  void put_each(const List& values, Put put_one) {
    out_.push_back('[');
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (k > 0) out_.push_back(',');
      put_one(values[k]);
    }
    out_.push_back(']');
  }
  /// Writes the shortest decimal text that reads back as the same value.
  template <class T>
  void put_number(T value) {
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) return null();
    }
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    out_.append(buffer, end);
  }
  void null() { out_.append("null"); }

  std::string& out_;
};

}  // namespace

void encode(const WavefrontMessage& message, std::string& text) {
  ObjectWriter(text).write(message);
}

std::span<const std::byte> encode(const SpotsMessage& message, std::string& text,
                                  std::vector<std::byte>& scratch) {
  ObjectWriter(text).write(message);

  scratch.resize(message.spots.size() * 6 * sizeof(float));
  const Vec2 unknown{std::nan(""), std::nan("")};
  std::byte* to = scratch.data();
  for (std::size_t i = 0; i < message.spots.size(); ++i) {
    const SpotFix& spot = message.spots[i];
    const Vec2 ref = i < message.reference_px.size() ? message.reference_px[i] : unknown;
    const float row[] = {spot.x, spot.y, float(ref.x), float(ref.y), spot.peak, spot.quality};
    std::memcpy(to, row, sizeof row);
    to += sizeof row;
  }
  return scratch;
}

std::span<const std::byte> encode(const CorrectorMessage& message, std::string& text) {
  ObjectWriter(text).write(message);
  return std::as_bytes(message.commands);
}

std::span<const std::byte> encode(const ImageMessage& message, std::string& text,
                                  std::vector<std::byte>& scratch) {
  const ImageView& image = message.image;
  ObjectWriter(text).write(message);
  const bool bytes = traits_of(image.format).layout == PixelLayout::bytes;

  const std::size_t line = std::size_t(image.width) * (bytes ? 1 : 2);
  const std::size_t rows = std::size_t(image.height);
  if (in_place(image) && std::ptrdiff_t(line) == image.stride_bytes) {
    return {image.data, line * rows};
  }
  scratch.resize(line * rows);
  visit_rows(image, 0, 0, image.width, image.height,
             [&](int x, int y, const auto* pixels, int count) {
               std::memcpy(scratch.data() + std::size_t(y) * line + std::size_t(x) * sizeof *pixels,
                           pixels, std::size_t(count) * sizeof *pixels);
             });
  return scratch;
}

std::span<const std::byte> encode(const PhaseMessage& message, std::string& text) {
  const Image<float>& waves = *message.waves;
  ObjectWriter(text).write(message);
  return std::as_bytes(std::span(waves.pixels));
}

std::optional<double> rms_waves(const RefinedMessage& message) {
  if (!message.valid) return std::nullopt;
  double squares = 0.0;
  for (std::size_t k = 0; k < message.j.size(); ++k) {
    if (message.j[k] > 2) squares += message.coefficients[k] * message.coefficients[k];
  }
  return std::sqrt(squares);
}

std::string encode(const RefinedMessage& message) {
  return json_text(to_json(message));
}

std::string encode(const StatusMessage& message) {
  return json_text(to_json(StreamedStatus{message}));
}

std::string encode(const EventMessage& message) {
  return json_text(to_json(message));
}

}  // namespace ovws
