#include "daemon/shared/log.hpp"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <poll.h>
#include <unistd.h>

#include <climits>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <mutex>

namespace ovws {
namespace {

/// Adds journal priorities: a line that begins with "<4>" has priority 4, see sd-daemon(3).
class JournalPriority : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    const char priority = message.level >= spdlog::level::critical ? '2'
                          : message.level == spdlog::level::err    ? '3'
                          : message.level == spdlog::level::warn   ? '4'
                          : message.level == spdlog::level::info   ? '6'
                                                                   : '7';
    const char text[] = {'<', priority, '>'};
    out.append(text, text + sizeof(text));
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JournalPriority>();
  }
};

/// Non-blocking log sink on standard error. Lines that a slow reader cannot take are dropped, and a
/// later line reports their number.
class QuickSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (!ready()) {
      ++lost_;
      return;
    }
    if (lost_ > 0) {
      const std::string note = std::to_string(std::exchange(lost_, 0)) + " log lines were lost\n";
      write(note.data(), note.size());
      if (!ready()) {
        ++lost_;
        return;
      }
    }
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    write(line.data(), line.size());
  }
  void flush_() override {}

 private:
  /// Whether standard error accepts output; a ready pipe takes PIPE_BUF bytes without blocking.
  static bool ready() {
    pollfd out{STDERR_FILENO, POLLOUT, 0};
    return ::poll(&out, 1, 0) == 1 && (out.revents & POLLOUT) != 0;
  }
  static void write(const char* text, std::size_t size) {
    constexpr std::size_t kMaxBytes = PIPE_BUF;
    if (size <= kMaxBytes) {
      (void)!::write(STDERR_FILENO, text, size);
      return;
    }
    std::string cut(text, kMaxBytes - 1);
    cut += '\n';
    (void)!::write(STDERR_FILENO, cut.data(), cut.size());
  }

  std::size_t lost_ = 0;
};

static_assert(int(LogLevel::error) == int(spdlog::level::err), "both have the same levels");
spdlog::level::level_enum level_of(LogLevel level) {
  return spdlog::level::level_enum(int(level));
}

}  // namespace

void start_log(LogLevel level) {
  auto logger = std::make_shared<spdlog::logger>("ovwsd", std::make_shared<QuickSink>());
  if (std::getenv("JOURNAL_STREAM") != nullptr) {
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<JournalPriority>('*').set_pattern("%*%v");
    logger->set_formatter(std::move(formatter));
  } else {
    logger->set_pattern("%Y-%m-%d %H:%M:%S.%e %-7l %v");
  }
  logger->set_level(level_of(level));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

void set_log_level(LogLevel level) {
  spdlog::default_logger()->set_level(level_of(level));
}

}  // namespace ovws
