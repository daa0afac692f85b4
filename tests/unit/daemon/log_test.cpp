/// The log, when the reader of standard error does not read.
#include "daemon/shared/log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <string>

namespace ovws {
namespace {

/// Redirects standard error to a pipe during its lifetime.
class StderrPipe {
 public:
  StderrPipe() : before_(dup(STDERR_FILENO)) {
    EXPECT_EQ(pipe(ends_.data()), 0);
    dup2(ends_[1], STDERR_FILENO);
    fcntl(ends_[0], F_SETFL, O_NONBLOCK);
  }
  ~StderrPipe() {
    dup2(before_, STDERR_FILENO);
    for (const int fd : {before_, ends_[0], ends_[1]}) close(fd);
  }
  std::string read_all() const {
    std::string text;
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = read(ends_[0], part.data(), part.size())) > 0;) {
      text.append(part.data(), std::size_t(got));
    }
    return text;
  }

 private:
  int before_;
  std::array<int, 2> ends_{};
};

TEST(Log, AReaderThatDoesNotReadLosesLinesAndHoldsNobodyUp) {
  const StderrPipe pipe;
  start_log(LogLevel::info);
  for (int i = 0; i < 20'000; ++i)
    spdlog::info("line {} of many", i);  // much more than a pipe's buffer
  const std::string kept = pipe.read_all();
  EXPECT_NE(kept.find("line 0 of many\n"), std::string::npos);
  EXPECT_EQ(kept.back(), '\n');
  spdlog::info("and on");
  const std::string after = pipe.read_all();
  EXPECT_NE(after.find("log lines were lost\n"), std::string::npos);
  EXPECT_NE(after.find("and on\n"), std::string::npos);
}

TEST(Log, ALineLongerThanAPipeTakesAtOnceIsCut) {
  const StderrPipe pipe;
  start_log(LogLevel::info);
  spdlog::info("{}", std::string(100'000, 'x'));
  const std::string text = pipe.read_all();
  EXPECT_LE(text.size(), 4096U);
  EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace ovws
