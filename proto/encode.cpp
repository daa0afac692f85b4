#include "proto/encode.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

static_assert(std::endian::native == std::endian::little, "binary parts are little-endian");

/// Writes one flat JSON object into a string that the caller reuses. Keys and strings given here
/// are our own names, which need no escapes.
class ObjectWriter {
 public:
  ObjectWriter(std::string& out, std::string_view topic) : out_(out) {
    out_.assign(1, '{');
    key("schema");
    out_.append("\"ovws.").append(topic).append("/1\"");
  }

  void integer(std::string_view name, std::int64_t value) { whole(name, value); }
  void count(std::string_view name, std::uint64_t value) { whole(name, value); }
  void boolean(std::string_view name, bool value) { raw(name, value ? "true" : "false"); }
  void string(std::string_view name, std::string_view value) {
    key(name);
    out_.append(1, '"').append(value).append(1, '"');
  }
  void number(std::string_view name, std::optional<double> value) {
    key(name);
    element(value.value_or(std::nan("")));
  }
  void raw(std::string_view name, std::string_view text) {
    key(name);
    out_.append(text);
  }
  void integers(std::string_view name, std::span<const int> values) {
    array(name, values, [this](int value) { put(value); });
  }
  void numbers(std::string_view name, std::span<const float> values, bool known) {
    array(name, values, [this, known](float value) { known ? element(value) : null(); });
  }
  void finish() { out_.push_back('}'); }

 private:
  void key(std::string_view name) {
    if (out_.size() > 1) out_.push_back(',');
    out_.append(1, '"').append(name).append("\":");
  }
  template <class T>
  void whole(std::string_view name, T value) {
    key(name);
    put(value);
  }
  template <class T, class Put>
  void array(std::string_view name, std::span<const T> values, Put put_one) {
    key(name);
    out_.push_back('[');
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (k > 0) out_.push_back(',');
      put_one(values[k]);
    }
    out_.push_back(']');
  }
  template <class T>
  void element(T value) {
    std::isfinite(value) ? put(value) : null();
  }
  void null() { out_.append("null"); }
  /// The shortest text that reads back as the same value.
  template <class T>
  void put(T value) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    out_.append(buffer, end);
  }

  std::string& out_;
};

void write_frame(ObjectWriter& w, const FrameMessage& m) {
  w.count("seq", m.seq);
  w.count("frame_id", m.frame_id);
  w.count("gap", m.gap);
  w.integer("t_device_ns", m.t_device_ns);
  w.integer("t_arrival_ns", m.t_arrival_ns);
  w.integer("t_publish_ns", m.t_publish_ns);
  w.number("latency_us", m.latency_us);
  w.count("hologram_id", m.hologram_id);
  w.boolean("settled", m.settled);
  w.integer("charge", m.charge);
  w.string("tracker", m.tracker);
  w.integer("subapertures", m.subapertures);
  w.integer("tracked", m.tracked);
  w.boolean("valid", m.valid);
  w.string("unit", "wave");
  w.number("wavelength_nm", m.wavelength_nm);
  w.string("basis", "zernike-osa-rms");
  w.string("orientation", "x-right-y-down");
  w.number("rms_waves", m.valid ? m.rms_waves : std::nullopt);
  w.number("fit_residual_px", m.fit_residual_px);
  w.number("gain_db", m.gain_db);
  w.number("gain_raw", m.gain_raw);
  w.number("exposure_us", m.exposure_us);
  w.number("saturated", m.saturated);
  w.string("loop", m.loop_closed ? "closed" : "open");
  w.number("reference_introduced_rms_waves", m.reference_introduced_rms_waves);
}

void write_shape(ObjectWriter& w, std::size_t rows, std::size_t cols, std::string_view dtype) {
  const int shape[] = {int(rows), int(cols)};
  w.integers("shape", shape);
  w.string("dtype", dtype);
}

/// What `image` and `phase` both say of their frame.
template <class Message>
void write_picture(ObjectWriter& w, const Message& m) {
  w.count("seq", m.seq);
  w.count("frame_id", m.frame_id);
  w.integer("t_arrival_ns", m.t_arrival_ns);
  w.count("hologram_id", m.hologram_id);
  w.string("orientation", "x-right-y-down");
}

}  // namespace

void encode(const WavefrontMessage& message, std::string& json) {
  ObjectWriter w(json, kTopicWavefront);
  write_frame(w, message);
  w.integers("j", message.j);
  w.numbers("coefficients", message.coefficients, message.valid);
  w.finish();
}

std::span<const std::byte> encode(const SpotsMessage& message, std::string& json,
                                  std::vector<std::byte>& scratch) {
  ObjectWriter w(json, kTopicSpots);
  write_frame(w, message);
  write_shape(w, message.spots.size(), 6, "<f4");
  w.raw("columns", R"(["x","y","ref_x","ref_y","peak","quality"])");
  w.raw("column_units", R"(["px","px","px","px","DN","1"])");
  w.finish();

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

std::span<const std::byte> encode(const ImageMessage& message, std::string& json,
                                  std::vector<std::byte>& scratch) {
  const ImageView& image = message.image;
  const bool bytes = traits_of(image.format).layout == PixelLayout::bytes;
  ObjectWriter w(json, kTopicImage);
  write_picture(w, message);
  write_shape(w, std::size_t(image.height), std::size_t(image.width), bytes ? "<u1" : "<u2");
  w.string("pixel_format", pixel_format_name(image.format));
  w.integer("significant_bits", significant_bits(image.format));
  w.finish();

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

std::span<const std::byte> encode(const PhaseMessage& message, std::string& json) {
  const Image<float>& waves = *message.waves;
  ObjectWriter w(json, kTopicPhase);
  write_picture(w, message);
  w.boolean("valid", message.valid);
  w.string("unit", "wave");
  w.number("wavelength_nm", message.wavelength_nm);
  write_shape(w, std::size_t(waves.height), std::size_t(waves.width), "<f4");
  w.finish();
  return std::as_bytes(std::span(waves.pixels));
}

}  // namespace ovws
