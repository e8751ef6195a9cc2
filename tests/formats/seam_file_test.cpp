// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/seam_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "cf/base/error.h"
#include "formats/seam_examples.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using support::same;

class SeamFile : public ::testing::Test {
 protected:
  SeamFile() {
    std::mt19937 random(1);
    GeoSegment segment;
    messages_.push_back(support::someHello());
    for (std::uint32_t photo = 0; photo < 2; ++photo) {
      segment = support::grownSegment(segment, random);
      SeamStep message;
      message.step.uav = 2;
      message.step.keyframes = {support::someKeyframe({2, photo}, 1, random)};
      message.step.segments = std::make_shared<std::vector<GeoSegment>>(1, segment);
      message.step.jpeg = "jpeg";
      messages_.push_back(message);
    }
    messages_.push_back(support::someDone());
    SeamWriter writer(file_);
    for (const SeamMessage& message : messages_) {
      writer.write(message);
      ends_.push_back(writer.bytes());
    }
    bytes_ = support::fileText(file_);
  }

  void write(const std::string& bytes) { support::writeText(file_, bytes); }

  /// All messages that are there; each must be the right one.
  std::size_t readAll(SeamReader& reader, std::size_t first = 0) {
    std::size_t count = first;
    while (const auto message = reader.next()) {
      EXPECT_LT(count, messages_.size());
      if (count < messages_.size()) {
        EXPECT_TRUE(same(*message, messages_[count])) << count;
      }
      ++count;
    }
    return count;
  }

  const support::TempFolder folder_;
  const std::filesystem::path file_ = folder_ / "north \xC3\xA9.seam";
  std::vector<SeamMessage> messages_;
  std::vector<std::uint64_t> ends_;
  std::string bytes_;
};

TEST_F(SeamFile, givesAllMessagesInOrderAndThenItsEnd) {
  EXPECT_EQ(bytes_.size(), ends_.back());
  SeamReader reader(file_);
  EXPECT_FALSE(reader.ended());
  EXPECT_EQ(readAll(reader), messages_.size());
  EXPECT_TRUE(reader.ended());
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.bytes(), bytes_.size());
}

TEST_F(SeamFile, aWriterWithoutAFileCountsTheSame) {
  SeamWriter counter;
  for (const SeamMessage& message : messages_) counter.write(message);
  EXPECT_EQ(counter.bytes(), bytes_.size());
}

TEST_F(SeamFile, eachMessageIsThereWhenWritten) {
  const auto file = folder_ / "growing.seam";
  SeamReader reader(file);
  EXPECT_FALSE(reader.next());  // not there yet
  SeamWriter writer(file);
  EXPECT_FALSE(reader.next());
  for (std::size_t k = 0; k < messages_.size(); ++k) {
    EXPECT_FALSE(reader.ended());
    writer.write(messages_[k]);
    EXPECT_EQ(readAll(reader, k), k + 1);
  }
  EXPECT_TRUE(reader.ended());
}

TEST_F(SeamFile, cutAnywhereAWriterGoesOnWithIt) {
  for (std::size_t size = 0; size <= bytes_.size(); size += size + 50 < bytes_.size() ? 13 : 1) {
    write(bytes_.substr(0, size));
    SeamWriter writer = SeamWriter::goOn(file_);
    for (const SeamMessage& message : messages_) writer.write(message);
    ASSERT_EQ(writer.bytes(), bytes_.size()) << size;
    ASSERT_TRUE(support::fileText(file_) == bytes_) << size;
  }
}

TEST_F(SeamFile, whatDoesNotGoOnWithItIsRefused) {
  write(bytes_.substr(0, ends_[2]));
  SeamWriter writer = SeamWriter::goOn(file_);
  SeamHello hello = support::someHello();
  hello.photos.reset();  // as it was known then
  hello.warnings = {"another"};
  writer.write(hello);
  writer.write(messages_[1]);
  EXPECT_THROW(writer.write(messages_[1]), RunError);
  EXPECT_THROW(writer.write(messages_[3]), RunError);
  SeamWriter of_another = SeamWriter::goOn(file_);
  hello.name = "south";
  EXPECT_THROW(of_another.write(hello), RunError);
  EXPECT_TRUE(support::fileText(file_) == bytes_.substr(0, ends_[2]));
}

TEST_F(SeamFile, cutAnywhereItGivesWhatIsWholeAndWaits) {
  for (std::size_t size = 0; size < bytes_.size(); ++size) {
    write(bytes_.substr(0, size));
    SeamReader reader(file_);
    const auto whole = std::upper_bound(ends_.begin(), ends_.end(), size) - ends_.begin();
    ASSERT_EQ(readAll(reader), static_cast<std::size_t>(whole)) << size;
    ASSERT_FALSE(reader.ended()) << size;
  }
}

TEST_F(SeamFile, canBeFollowedByteByByte) {
  write("");
  SeamReader reader(file_);
  std::size_t count = 0;
  std::ofstream out(file_, std::ios::binary);
  for (std::size_t at = 0; at < bytes_.size(); ++at) {
    count = readAll(reader, count);
    out.put(bytes_[at]).flush();
  }
  EXPECT_EQ(readAll(reader, count), messages_.size());
  EXPECT_TRUE(reader.ended());
}

TEST_F(SeamFile, aFlippedBitAnywhereIsRefused) {
  for (std::size_t at = 0; at < bytes_.size(); ++at) {
    std::string flipped = bytes_;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << at % 8));
    write(flipped);
    SeamReader reader(file_);
    try {
      readAll(reader);
      FAIL() << "accepted bit " << at % 8 << " of byte " << at;
    } catch (const RunError& error) {
      const std::string line = error.what();
      const auto begin = std::upper_bound(ends_.begin(), ends_.end(), at);
      const std::uint64_t message = at < 8 ? 0 : begin == ends_.begin() ? 8 : *(begin - 1);
      EXPECT_NE(line.find(file_.string()), std::string::npos);
      EXPECT_NE(line.find("at byte " + std::to_string(message) + ")"), std::string::npos) << line;
    }
  }
}

TEST_F(SeamFile, moreThanItsEndOrLessThanBeforeIsRefused) {
  write(bytes_ + "x");
  SeamReader reader(file_);
  EXPECT_THROW(readAll(reader), RunError);
  EXPECT_TRUE(reader.ended());
  write(bytes_.substr(0, 20));
  SeamReader again(file_);
  readAll(again);
  write(bytes_.substr(0, 5));
  EXPECT_THROW((void)again.next(), RunError);
}

TEST_F(SeamFile, whatCannotBeWrittenOrReadIsNamed) {
  EXPECT_THROW(SeamWriter(folder_ / "no/such/folder.seam"), RunError);
  SeamReader folder(folder_.path());
  EXPECT_THROW((void)folder.next(), RunError);
  if (std::filesystem::exists("/dev/full")) {
    EXPECT_THROW(SeamWriter("/dev/full"), RunError);
  }
}

}  // namespace
}  // namespace cf
