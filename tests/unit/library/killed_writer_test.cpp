/// A process that stores, drops and replaces files in a loop is killed at random moments.
/// Afterwards every file is complete, and in the state before or after the interrupted step.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <thread>

#include "daemon/ovwsd/library/state_folder.hpp"
#include "daemon/shared/atomic_file.hpp"
#include "daemon/shared/encoding.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kKills = 200;
constexpr std::size_t kValueCount = 1 << 16;  // 350 kB of text

json content_at(int step) {
  const std::vector<float> values(kValueCount, float(step));
  return {{"step", step}, {"values", base64_of(values)}};
}

bool consistent(const json& content) {
  return content == content_at(content["step"].get<int>());
}

std::string config_of(int step) {
  std::string text;
  for (int line = 0; line < 2000; ++line) text += std::to_string(step) + "\n";
  return text;
}

struct Report {
  int step = 0;
  bool finished = false;
};

/// The child process, which never returns: in turn it stores an item, drops it, and replaces a
/// configuration. It reports the begin and the end of each step through `pipe_fd`.
[[noreturn]] void write_until_killed(const std::string& folder, int step, int pipe_fd) {
  auto store = StateFolder::open(folder + "/state");
  if (!store) _exit(1);
  for (;; ++step) {
    const auto say = [&](bool finished) {
      const Report reported{step, finished};
      if (::write(pipe_fd, &reported, sizeof reported) != sizeof reported) _exit(2);
    };
    const json content = content_at(step);
    const std::string config = config_of(step);
    say(false);
    bool done = false;
    if (step % 4 == 3) {
      done = store->remove("item", "only").has_value();
    } else if (step % 4 == 2) {
      done = replace_file(folder + "/config.json", config).has_value();
    } else {
      done = store->write("item", "only", StateFolder::text_of("item", content)).has_value();
    }
    if (!done) _exit(3);
    say(true);
  }
}

/// What is on the disk: the step that wrote the item, if it is there, and the step that wrote the
/// configuration; 0: none.
struct Found {
  std::optional<int> item;
  int config = 0;
  friend bool operator==(const Found&, const Found&) = default;
};

Found after(Found found, int step) {
  if (step % 4 == 3) {
    found.item.reset();
  } else if (step % 4 == 2) {
    found.config = step;
  } else {
    found.item = step;
  }
  return found;
}

class KilledWriter : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_ + "/state"); }
  void TearDown() override { fs::remove_all(folder_); }

  /// Starts a writer with `step`, kills it after `delay`, and returns what it reported.
  std::vector<Report> killed_after(int step, std::chrono::microseconds delay) const {
    int ends[2];
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const pid_t child = ::fork();
    if (child == 0) write_until_killed(folder_, step, ends[1]);
    ::close(ends[1]);
    std::vector<Report> reported;
    Report one;
    // The delay counts from the first step, since a slow machine may take long to start.
    if (::read(ends[0], &one, sizeof one) == sizeof one) reported.push_back(one);
    std::this_thread::sleep_for(delay);
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status)) << "the writer ended by itself: " << WEXITSTATUS(status);
    while (::read(ends[0], &one, sizeof one) == sizeof one) reported.push_back(one);
    ::close(ends[0]);
    return reported;
  }

  Found find() const {
    Found found;
    remove_leftovers(folder_);
    const auto store = StateFolder::open(folder_ + "/state");
    EXPECT_TRUE(store);
    for (const std::string& name : store->names("item")) {
      const auto item = store->read("item", name);
      EXPECT_TRUE(item) << name << ": " << item.error().reason;
      if (!item) continue;
      EXPECT_TRUE(consistent(item->content));
      found.item = item->content["step"].get<int>();
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ + "/state"), {}),
              std::ptrdiff_t(found.item.has_value()));
    std::ostringstream text;
    text << std::ifstream(folder_ + "/config.json").rdbuf();
    if (!text.str().empty()) found.config = std::stoi(text.str());
    EXPECT_TRUE(found.config == 0 || text.str() == config_of(found.config));
    return found;
  }

  const std::string folder_ = own_folder("killed_writer");
};

TEST_F(KilledWriter, WhateverMomentItIsKilledAtTheOldOrTheNewIsFoundWhole) {
  std::mt19937 random(7);
  Found expected;
  int step = 1;
  int interrupted = 0, taken_over = 0;
  for (int kill = 0; kill < kKills && !HasFailure(); ++kill) {
    const auto delay = std::chrono::microseconds(random() % 40000);
    Found old = expected;
    int begun = 0;  // 0: none
    for (const Report& reported : killed_after(step, delay)) {
      step = reported.step + 1;
      begun = reported.step;
      if (!reported.finished) continue;
      old = after(old, reported.step);
      begun = 0;
    }
    const Found found = find();
    const bool is_old = found == old;
    const bool is_new = begun != 0 && found == after(old, begun);
    EXPECT_TRUE(is_old || is_new) << "kill " << kill << ": item of step " << found.item.value_or(-1)
                                  << ", after step " << step - 1;
    interrupted += begun != 0;
    taken_over += begun != 0 && is_new && !is_old;
    expected = found;
  }
  std::printf("  %d kills over %d steps: %d within a step, %d of them behind the rename\n", kKills,
              step - 1, interrupted, taken_over);
  EXPECT_GT(interrupted, kKills / 4) << "too few kills hit a step to say anything";
}

}  // namespace
}  // namespace ovws
