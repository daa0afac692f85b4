/// ovws check: the acceptance report of a bench.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "daemon/examine/check/judge.hpp"
#include "daemon/examine/check/measure.hpp"
#include "daemon/examine/check/report.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "daemon/ovws/text/wrap.hpp"

namespace ovws::cli {
namespace {

struct AcceptanceOptions {
  std::string output;     ///< HTML file; empty: none
  double seconds = 60.0;  ///< for noise and drift
  bool quick = false;
  bool open_loop = false;  ///< opens a closed loop for the check
  bool no_loop = false;    ///< does not close the loop
};

/// Whether the report can be written, asked before minutes of measurement.
Result<void> check_output(const std::string& path) {
  if (path.empty()) return {};
  std::error_code ignored;
  const bool existed = std::filesystem::exists(path, ignored);
  const bool can_write = std::ofstream(path, std::ios::app).good();  // keeps a former report
  if (!existed) std::filesystem::remove(path, ignored);
  if (can_write) return {};
  return fail(Errc::unavailable, "output", path + " cannot be written");
}

void print_report(const Common& common, const examine::Measured& measured,
                  const examine::Findings& findings, const std::string& path) {
  constexpr std::size_t kIndent = 3;
  print_result(common, examine::report_json(measured, findings),
               wrapped(examine::report_text(findings), terminal_columns(), kIndent) +
                   (path.empty() ? "" : "\nreport: " + path));
}

/// Measures the bench and prints the report. Returns kError if a verdict is bad.
int check_acceptance(const Common& common, const AcceptanceOptions& options) {
  if (const auto usable = check_output(options.output); !usable) {
    return report(common, usable.error());
  }
  catch_interrupts();
  examine::Hooks hooks;
  hooks.interrupted = was_interrupted;
  hooks.progress = [](const std::string& text, double seconds_left) {
    study::print_progress(text + ", " + time_text(std::ceil(seconds_left)) + " left");
  };
  const auto measured = examine::measure(
      common, {options.seconds, options.quick, options.open_loop, !options.no_loop}, hooks);
  study::print_progress("");
  if (!measured) return report_failure(common, measured.error());
  const examine::Findings findings = examine::answers(*measured);
  auto written = options.output.empty()
                     ? Result<void>()
                     : study::write_text(examine::report_html(*measured, findings), options.output);
  print_report(common, *measured, findings, written ? options.output : "");
  if (!written) return report(common, written.error());
  return examine::worst(findings) == examine::Severity::bad ? kError : kOk;
}

}  // namespace

void add_check(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "check",
      "measure how good the bench is, and say what to improve first: response to 0.1 wave of each "
      "mode, noise, vibration, drift, settle time, look-up table, closed loop; takes about two "
      "minutes",
      check_acceptance);
  command.footer(
      "Needs a reference. Restores the aberration, the loop, its correction and the look-up "
      "table,\n"
      "also after Ctrl-C or an error.\n\n"
      "Exit codes: 0 no verdict is bad; 1 one is, or the check failed; 2 the command line is\n"
      "wrong; 3 no daemon answered in time.");
  command.add_option("--output,-o", options.output,
                     "write the report as one HTML file with figures, e.g. report.html");
  command.add_option("--seconds", options.seconds, "time for noise and drift, s")
      ->capture_default_str()
      ->check(number_from(2.0, 3600.0));
  command.add_flag("--quick", options.quick,
                   "half a minute: fewer frames, at most 10 s for noise and drift, no measurement "
                   "of the look-up table");
  command.add_flag("--open-loop", options.open_loop,
                   "open a closed loop, and close it again at the end");
  command.add_flag("--no-loop", options.no_loop, "do not close the loop");
}

}  // namespace ovws::cli
