/// ovws check: the acceptance report of a bench.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "daemon/examine/check/judge.hpp"
#include "daemon/examine/check/measure.hpp"
#include "daemon/examine/check/report.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "daemon/ovws/text/wrap.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

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
  if (common.json) {
    print("{}\n", json_text(examine::report_json(measured, findings)));
    return;
  }
  constexpr std::size_t kIndent = 3;
  print("{}\n", wrapped(examine::report_text(findings), terminal_columns(), kIndent));
  if (!path.empty()) print("report: {}\n", path);
}

}  // namespace

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

}  // namespace ovws::cli
