/// Figures: numbers as CSV, drawn by gnuplot as PNG or SVG.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {

struct Series {
  std::string name;
  std::vector<double> x{}, y{};
  std::vector<double> error{};  ///< standard error of each y; empty: no error bars
  /// `line` is dashed; `solid` is a line without points.
  enum class Style { line_points, line, points, solid } style = Style::line_points;
  /// Colour number: the colour of this series of the figure, counted from 1; 0: the default colour.
  int colour = 0;
  static constexpr int kBlack = -1;
  bool in_legend = true;
  double shift_x = 0.0;  ///< horizontal offset, so that points do not cover each other

  /// Appends a point. A Mean also appends its standard error.
  void add(double at_x, double value) {
    x.push_back(at_x);
    y.push_back(value);
  }
  void add(double at_x, const Mean& value) {
    add(at_x, value.value);
    error.push_back(value.standard_error);
  }
};

struct Figure {
  std::string name;  ///< name of the files, without extension
  std::string title;
  std::string x_label, y_label;  ///< with units
  bool log_x = false, log_y = false;
  bool same_scale = false;  ///< equal scales in x and y
  std::vector<Series> series{};
  double y_from = std::numeric_limits<double>::quiet_NaN();  ///< axis start; NaN: from the data
  double y_to = std::numeric_limits<double>::quiet_NaN();
  double x_step = std::numeric_limits<double>::quiet_NaN();  ///< distance of tics; NaN: automatic

  /// Adds a series, unless it has no points.
  void add(Series one) {
    if (!one.x.empty()) series.push_back(std::move(one));
  }
};

/// Writes a text file. Errc::unavailable (field "output"): the file cannot be written.
Result<void> write_text(const std::string& text, const std::filesystem::path& path);

/// Writes NAME.csv (series,x,y,error) and NAME.gnuplot, which draws NAME.png in the current folder.
/// Errors (Errc::unavailable): the folder cannot be written.
Result<void> write_numbers(const Figure& figure, const std::filesystem::path& folder);

/// Draws NAME.png from the files of write_numbers. Errors (Errc::unavailable): gnuplot is missing
/// or fails; the reason says what to do.
Result<void> draw(const Figure& figure, const std::filesystem::path& folder);

/// The figure as an SVG element for an HTML page. Errors (Errc::unavailable): gnuplot is missing or
/// fails; the reason says what to do.
Result<std::string> svg_of(const Figure& figure);

}  // namespace ovws::study
