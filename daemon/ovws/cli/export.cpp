/// ovws export: writes the measurements and images of a recording as CSV and PNG files.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "core/base/pixels.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/image_file.hpp"
#include "daemon/shared/encoding.hpp"
#include "drivers/replay/recording_reader.hpp"
#include "proto/json_text.hpp"
#include "proto/strict_json.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

struct ExportOptions {
  std::string path;
  std::string prefix;  ///< begin of the files' names; empty: the recording's name
  bool csv = false, spots = false, images = false;
};

constexpr int kMaxDepth = 64;

tl::unexpected<Error> damaged(const std::string& what) {
  return fail(Errc::invalid, "path", "the recording is damaged: " + what);
}

tl::unexpected<Error> modes_changed() {
  return fail(Errc::refused, "path",
              "the modes changed during the recording, so that a column would have two meanings: "
              "read it frame by frame (proto/RECORDING.md)");
}

/// OSA/ANSI indices of the columns of a recording, as far as a frame has values in them.
Result<std::vector<int>> recorded_modes(RecordingReader& reader) {
  auto columns_j = reader.columns_j();
  if (!columns_j) return columns_j;
  std::vector<int>& modes_j = *columns_j;
  std::size_t used = 0;
  for (const RecordedFrame& f : reader.frames()) {
    used = std::max<std::size_t>(used, f.coefficients);
  }
  if (modes_j.size() < used) return damaged("the modes of its columns");
  modes_j.resize(used);
  if (std::ranges::any_of(modes_j, [](int j) { return j < 0; })) {
    return damaged("the modes of its columns");
  }
  if (std::ranges::find(modes_j, 0) != modes_j.end()) return modes_changed();
  return modes_j;
}

std::string text_of(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}
std::string text_of(float value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}

struct Column {
  const char* name;
  std::string (*text)(const RecordedFrame& frame);
};

template <class T>
std::string setting(const RecordedFrame& frame, T value) {
  return frame.settings_known != 0 ? text_of(value) : "";
}

/// Columns of a frame. Values that the stream would not publish are empty.
constexpr std::array kColumns{
    Column{"frame_id", [](const RecordedFrame& f) { return std::to_string(f.frame_id); }},
    Column{"t_arrival_ns", [](const RecordedFrame& f) { return std::to_string(f.t_arrival_ns); }},
    Column{"hologram_id", [](const RecordedFrame& f) { return std::to_string(f.hologram_id); }},
    Column{"valid", [](const RecordedFrame& f) { return std::to_string(f.valid); }},
    Column{"settled", [](const RecordedFrame& f) { return std::to_string(f.settled); }},
    Column{"tracked", [](const RecordedFrame& f) { return std::to_string(f.tracked); }},
    Column{"gain_db", [](const RecordedFrame& f) { return setting(f, f.gain_db); }},
    Column{"gain_raw", [](const RecordedFrame& f) { return setting(f, f.gain_raw); }},
    Column{"exposure_us", [](const RecordedFrame& f) { return setting(f, f.exposure_us); }},
    Column{"rms_waves",
           [](const RecordedFrame& f) { return f.valid != 0 ? text_of(f.rms_waves) : ""; }},
    Column{"fit_residual_px", [](const RecordedFrame& f) {
             return f.valid != 0 || f.explained == 0 ? text_of(f.fit_residual_px) : "";
           }}};

/// Cells of one frame, empty where it has no valid value.
std::string cells(const std::vector<float>& waves, std::size_t columns, bool valid) {
  std::string text;
  for (std::size_t k = 0; k < columns; ++k) {
    text += ',';
    if (valid && k < waves.size()) text += text_of(waves[k]);
  }
  return text;
}

/// What the coefficients mean, the same in each line: a table has no other place for it that every
/// reader of CSV accepts.
constexpr const char* kMeaningHead = ",unit,wavelength_nm,basis,orientation";

std::string meaning(const RecordingHeader& header) {
  return fmt::format(",wave,{},{},{}", header.wavelength_nm, kBasisName, kOrientationName);
}

Result<void> write_modes(RecordingReader& reader, std::ostream& out) {
  const auto modes_j = recorded_modes(reader);
  if (!modes_j) return fail(modes_j.error());
  std::string head;
  for (const Column& column : kColumns) head += std::string(column.name) + ',';
  head.pop_back();
  for (const int j : *modes_j) head += fmt::format(",j{}", j);
  for (const int j : *modes_j) head += fmt::format(",sigma_j{}", j);
  out << head << kMeaningHead << '\n';
  const std::string meant = meaning(reader.header());
  for (const RecordedFrame& frame : reader.frames()) {
    const auto waves = reader.coefficients(frame);
    const auto sigma = reader.sigma_waves(frame);
    if (!waves || !sigma) return fail((waves ? sigma : waves).error());
    std::string line;
    for (const Column& column : kColumns) line += column.text(frame) + ',';
    line.pop_back();
    out << line << cells(*waves, modes_j->size(), frame.valid != 0)
        << cells(*sigma, modes_j->size(), frame.valid != 0) << meant << '\n';
  }
  return {};
}

Result<void> write_spots(RecordingReader& reader, std::ostream& out) {
  out << "frame_id,spot,x_px,y_px,peak_dn,quality,level_dn,noise_dn,first_pixel,orientation\n";
  for (const RecordedFrame& frame : reader.frames()) {
    const auto spots = reader.spots(frame);
    if (!spots) return fail(spots.error());
    for (std::size_t k = 0; k < spots->size(); ++k) {
      const RecordedSpot& s = (*spots)[k];
      out << fmt::format("{},{},{},{},{},{},{},{},0,{}\n", frame.frame_id, k, text_of(s.x),
                         text_of(s.y), text_of(s.peak), text_of(s.quality), text_of(s.level),
                         text_of(s.noise), kOrientationName);
    }
  }
  return {};
}

bool has_images(const RecordingReader& reader) {
  return std::ranges::any_of(reader.frames(),
                             [](const RecordedFrame& f) { return f.picture >= 0; });
}

/// Writes the images as PNG: 8 bits, or 16 bits with the camera's values. Their names have the row
/// of the frame, because a reopened camera counts its frames from the start again.
Result<void> export_images(RecordingReader& reader, const std::string& prefix,
                           std::vector<std::string>& files) {
  const RecordingHeader& header = reader.header();
  const bool bytes = traits_of(header.format).layout == PixelLayout::bytes;
  std::vector<std::byte> pixels(reader.image_bytes());
  cv::Mat picture(header.height, header.width, bytes ? CV_8UC1 : CV_16UC1);
  for (std::size_t number = 0; number < reader.frames().size(); ++number) {
    const RecordedFrame& frame = reader.frames()[number];
    if (frame.picture < 0) continue;
    if (auto read = reader.picture(frame, pixels); !read) return read;
    const ImageView view{pixels.data(), header.width,
                         header.height, std::ptrdiff_t(row_bytes(header.format, header.width)),
                         header.format, frame.left_justified_bits};
    visit_rows(view, 0, 0, view.width, view.height, [&](int x, int y, const auto* row, int count) {
      for (int i = 0; i < count; ++i) {
        if (bytes) picture.at<unsigned char>(y, x + i) = static_cast<unsigned char>(row[i]);
        if (!bytes) picture.at<std::uint16_t>(y, x + i) = row[i];
      }
    });
    files.push_back(fmt::format("{}-{:08}.png", prefix, number));
    if (auto written = write_image(files.back(), picture); !written) return written;
  }
  return {};
}

Result<std::vector<std::string>> write_export(const ExportOptions& options) {
  auto reader = RecordingReader::open(options.path);
  if (!reader) return fail(reader.error());
  const std::string prefix =
      options.prefix.empty() ? fs::path(options.path).stem().string() : options.prefix;
  if (options.images && !has_images(**reader)) {
    return fail(Errc::refused, "path",
                "the recording has no images: leave out --images, or record with pictures_every of "
                "at least 1");
  }
  const auto write = [&reader](auto writer) {
    return [&reader, writer](std::ostream& out) { return writer(**reader, out); };
  };
  std::vector<std::string> files;
  if (options.csv || (!options.spots && !options.images)) {
    files.push_back(prefix + ".csv");
    if (auto written = write_output(files.back(), write(write_modes)); !written)
      return fail(written.error());
  }
  if (options.spots) {
    files.push_back(prefix + "-spots.csv");
    if (auto written = write_output(files.back(), write(write_spots)); !written)
      return fail(written.error());
  }
  if (options.images) {
    auto written = export_images(**reader, prefix, files);
    if (!written) return fail(written.error());
  }
  return files;
}

int export_recording(const Common& common, const ExportOptions& options) {
  const auto files = write_export(options);
  if (!files) return report(common, files.error());
  return print_result(common, {{"files", *files}}, fmt::format("{}", fmt::join(*files, "\n")));
}

}  // namespace

void add_export(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "export",
      "write a recording as files for other programs, and print their names; replaces files of "
      "the same name; works offline",
      export_recording);
  command.add_option("file", options.path, "recording made by record.start")->required();
  command.add_flag("--csv", options.csv,
                   "NAME.csv: one line per frame, with its modes in waves and their standard "
                   "errors (default)");
  command.add_flag("--spots", options.spots,
                   "NAME-spots.csv: one line per spot of a frame, with its position");
  command.add_flag(
      "--images", options.images,
      "NAME-ROW.png: the image of each row of frames, counted from 0, with the camera's values, "
      "8 or 16 bits");
  command.add_option("--output,-o", options.prefix,
                     "NAME: begin of the files' names (default: the recording's name, in the "
                     "current folder)");
}

}  // namespace ovws::cli
