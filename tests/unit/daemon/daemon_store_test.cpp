/// The store's write-behind queue: a failed write stays queued, is retried and reports why, and a
/// disk that does not answer blocks only those that wait for it.
#include "daemon/ovwsd/store/daemon_store.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <thread>

#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "tests/support/file_limit.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/support/time.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Store : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  fs::path file(const std::string& name) const { return fs::path(folder_) / name; }
  /// Makes writes under this name fail: a folder that is not empty has it.
  void block(const std::string& name) const { fs::create_directories(file(name) / "full"); }
  void unblock(const std::string& name) const { fs::remove_all(file(name)); }

  struct Answers {
    DaemonStore::Tried tried() {
      return [this](const Result<std::string>& result) {
        (result ? kept : refused) += 1;
        if (!result) why = result.error().reason;
      };
    }
    int kept = 0, refused = 0;
    std::string why;
  };
  void put(const std::string& name, int value, Answers& answers) {
    store_.put("kind", name, {{"value", value}}, DaemonStore::Older::stays, answers.tried());
  }
  void try_again() {
    test::skip(std::chrono::seconds(2));
    while (store_.turn()) {
    }
  }
  json value(const std::string& name) const {
    const auto found = store_.find("kind", name);
    return found ? found->content["value"] : json();
  }
  std::vector<std::string> loaded() const {
    std::vector<std::string> names;
    store_.load("kind", [&](const StateItem& item) { names.push_back(item.name); });
    std::sort(names.begin(), names.end());
    return names;
  }

  const std::string folder_ = own_folder("daemon_store");
  StreamQueue queue_;
  Events events_{queue_};
  DaemonStore store_{{folder_}, events_};
};

TEST_F(Store, WhatIsRefusedWaitsAndIsWrittenWhenTheDiskTakesIt) {
  Answers a, b;
  block("kind.a.json");
  put("a", 1, a);
  EXPECT_EQ(a.refused, 1);
  ASSERT_TRUE(store_.report().reason);
  EXPECT_NE(store_.report().reason->find("kind.a.json"), std::string::npos);
  EXPECT_NE(store_.report().reason->find("; items waiting to be written again: 1"),
            std::string::npos);
  EXPECT_EQ(value("a"), 1) << "it is found while it waits";
  EXPECT_EQ(loaded(), std::vector<std::string>{"a"});
  try_again();
  EXPECT_EQ(a.refused, 1) << "said once";
  unblock("kind.a.json");
  put("b", 2, b);
  EXPECT_EQ(b.kept, 1);
  try_again();
  EXPECT_EQ(a.kept, 1);
  EXPECT_FALSE(store_.report().reason);
  EXPECT_EQ(store_.queued(), 0);
  EXPECT_EQ(value("a"), 1);
}

TEST_F(Store, ItIsTriedAgainWithoutAnythingNew) {
  Answers a;
  block("kind.a.json");
  put("a", 1, a);
  unblock("kind.a.json");
  (void)store_.turn();
  EXPECT_EQ(a.kept, 0) << "it rests between two tries";
  test::skip(std::chrono::seconds(2));
  (void)store_.turn();
  EXPECT_EQ(a.kept, 1);
}

TEST_F(Store, TheReasonIsThatOfTheNewestThatWaitsAndGoesWithIt) {
  Answers a, z;
  block("kind.a.json");
  block("kind.z.json");
  put("z", 1, z);
  put("a", 1, a);
  EXPECT_NE(store_.report().reason->find("kind.a.json"), std::string::npos);
  EXPECT_NE(store_.report().reason->find("; items waiting to be written again: 2"),
            std::string::npos);
  unblock("kind.a.json");
  try_again();
  EXPECT_NE(store_.report().reason->find("kind.z.json"), std::string::npos);
  EXPECT_NE(store_.report().reason->find("; items waiting to be written again: 1"),
            std::string::npos);
  unblock("kind.z.json");
  try_again();
  EXPECT_FALSE(store_.report().reason);
}

TEST_F(Store, OnlyTheNewestOfANameIsWritten) {
  Answers first, second;
  block("kind.a.json");
  put("a", 1, first);
  put("a", 2, second);
  EXPECT_EQ(store_.queued(), 1);
  unblock("kind.a.json");
  try_again();
  EXPECT_EQ(value("a"), 2);
  EXPECT_EQ(first.kept, 0);
  EXPECT_EQ(second.kept, 1);
}

TEST_F(Store, ADropThatFailsLosesNoWriteThatWaits) {
  Answers a;
  block("kind.a.json");
  put("a", 1, a);
  bool dropped = true;
  store_.drop("kind", "a", [&](const Result<void>& done) { dropped = done.has_value(); });
  EXPECT_FALSE(dropped) << "no unlink removes a folder";
  EXPECT_EQ(value("a"), 1) << "the caller goes on with it";
  ASSERT_TRUE(store_.report().reason);
  EXPECT_NE(store_.report().reason->find("; items waiting to be written again: 1"),
            std::string::npos);
  unblock("kind.a.json");
  try_again();
  EXPECT_EQ(a.kept, 1);
  EXPECT_EQ(value("a"), 1);
}

/// Not tested here: a read-only folder, which root can write to, and a full disk.
TEST_F(Store, ARemovedFolderIsCreatedAgain) {
  Answers a;
  fs::remove_all(folder_);
  put("a", 1, a);
  EXPECT_EQ(a.kept, 1);
  EXPECT_TRUE(fs::exists(file("kind.a.json")));
  EXPECT_FALSE(store_.report().reason);
}

TEST_F(Store, AnOutdatedItemIsNotLoadedByARestart) {
  Answers first, second;
  put("a", 1, first);
  ASSERT_EQ(first.kept, 1);
  const auto found_by_restart = [&] {
    DaemonStore again({folder_}, events_);
    const auto found = again.find("kind", "a");
    return found ? found->content["value"] : json();
  };
  {
    const test::FileLimit limit(16);
    store_.put("kind", "a", {{"value", 2}}, DaemonStore::Older::set_aside, second.tried());
    EXPECT_EQ(second.refused, 1);
    EXPECT_EQ(found_by_restart(), json());
    EXPECT_TRUE(fs::exists(file("kind.a.json.outdated"))) << "a person may want it";
  }
  try_again();
  EXPECT_EQ(second.kept, 1);
  EXPECT_EQ(found_by_restart(), 2);
  EXPECT_FALSE(fs::exists(file("kind.a.json.outdated")));
}

TEST_F(Store, WhatIsDroppedIsNotWrittenAfterAll) {
  Answers a;
  bool dropped = false;
  {
    const test::FileLimit limit(16);
    put("a", 1, a);
    ASSERT_EQ(a.refused, 1);
    store_.drop("kind", "a", [&](const Result<void>& done) { dropped = done.has_value(); });
  }
  EXPECT_TRUE(dropped);
  EXPECT_EQ(store_.queued(), 0);
  EXPECT_FALSE(store_.report().reason);
  try_again();
  EXPECT_EQ(value("a"), json());
}

TEST_F(Store, MoreThanItsMemoryIsNotKept) {
  Answers large, more;
  block("kind.large.json");
  const std::string text(DaemonStore::kMaxQueuedBytes - 4096, 'x');
  store_.put("kind", "large", text, DaemonStore::Older::stays, large.tried());
  EXPECT_EQ(large.refused, 1);
  store_.put("kind", "more", std::string(8192, 'x'), DaemonStore::Older::stays, more.tried());
  EXPECT_EQ(more.refused, 1);
  EXPECT_NE(more.why.find("MiB already wait to be written"), std::string::npos);
  EXPECT_EQ(store_.queued(), 1);
}

TEST_F(Store, AnOutdatedItemIsNotLoadedEvenIfTheNewOneIsTooLarge) {
  Answers first, second, third;
  put("a", 1, first);
  ASSERT_EQ(first.kept, 1);
  const std::string too_much(DaemonStore::kMaxQueuedBytes, 'x');
  store_.put("kind", "a", too_much, DaemonStore::Older::stays, second.tried());
  EXPECT_EQ(second.refused, 1);
  EXPECT_EQ(value("a"), 1);
  store_.put("kind", "a", too_much, DaemonStore::Older::set_aside, third.tried());
  EXPECT_EQ(third.refused, 1);
  EXPECT_EQ(store_.queued(), 0);
  EXPECT_EQ(value("a"), json());
  EXPECT_TRUE(fs::exists(file("kind.a.json.outdated")));
}

TEST(Disk, TwoDropsThatFailLoseNoWriteThatWaits) {
  const std::string folder = own_folder("two_drops");
  StreamQueue queue;
  Events events{queue};
  Disk disk;
  DaemonStore store({folder}, events, &disk);
  disk.begin();  // without a thread: everything waits
  fs::create_directories(fs::path(folder) / "kind.a.json" / "full");
  store.put("kind", "a", {{"value", 1}}, DaemonStore::Older::stays,
            [](const Result<std::string>&) {});
  int failed = 0;
  for (int k = 0; k < 2; ++k) {
    store.drop("kind", "a", [&](const Result<void>& done) { failed += done ? 0 : 1; });
  }
  EXPECT_FALSE(store.find("kind", "a"));
  while (store.turn()) {
  }
  EXPECT_EQ(failed, 2);
  EXPECT_EQ(store.queued(), 1);
  ASSERT_TRUE(store.find("kind", "a"));
  EXPECT_EQ(store.find("kind", "a")->content["value"], 1);
  fs::remove_all(folder);
}

/// Of a kind with a limited number of items, the oldest is deleted for each that is added. A
/// deletion that waits keeps the write that it replaces, in case it fails.
TEST(Disk, DeletionsDoNotFillTheMemoryWhileItStandsStill) {
  constexpr std::size_t kItem = DaemonStore::kMaxQueuedBytes / 8;
  const std::string folder = own_folder("displaced_writes");
  StreamQueue queue;
  Events events{queue};
  Disk disk;
  DaemonStore store({folder}, events, &disk);
  disk.begin();  // without a thread: it stands still
  int refused = 0;
  for (int k = 0; k < 12; ++k) {
    const std::string name = "item-" + std::to_string(k);
    store.put("kind", name, std::string(kItem, 'x'), DaemonStore::Older::set_aside,
              [&](const Result<std::string>& kept) {
                refused += kept || kept.error().code == Errc::refused ? 0 : 1;
              });
    store.drop("kind", name, [](const Result<void>&) {});
  }
  EXPECT_EQ(refused, 5);
  fs::remove_all(folder);
}

/// The disk thread waits for a disk that does not answer until the test releases it.
TEST(Disk, WhileItStandsStillNobodyWaits) {
  const std::string folder = own_folder("standing_disk");
  StreamQueue queue;
  Events events{queue};
  Disk disk;
  DaemonStore store({folder}, events, &disk);
  disk.each_turn([&] { return store.turn(); });
  std::promise<void> go;
  std::atomic<bool> stop{false};
  disk.begin();
  disk.post([&] { go.get_future().wait(); });
  std::thread thread([&] {
    while (!stop) disk.do_work();
    disk.on_close();
  });
  std::atomic<int> kept{0};
  store.put("kind", "a", {{"value", 1}}, DaemonStore::Older::set_aside,
            [&](const Result<std::string>& done) { kept += done ? 1 : 0; });
  EXPECT_EQ(store.find("kind", "a")->content["value"], 1);
  EXPECT_EQ(store.queued(), 1);
  int refused = 0;
  for (int request = 0; request < Disk::kMaxRequests + 1; ++request) {
    refused += disk.request([] {}) ? 0 : 1;
  }
  EXPECT_EQ(refused, 1);
  EXPECT_EQ(kept, 0);
  stop = true;
  go.set_value();
  thread.join();
  EXPECT_EQ(kept, 1) << "written before the thread ends";
  EXPECT_TRUE(fs::exists(fs::path(folder) / "kind.a.json"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace ovws
