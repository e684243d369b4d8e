#include "datasets/formats/table_note.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/temporary_folder.h"

namespace clothid::table_note_test {
namespace {

TEST(TableNote, TellsDecimalCommas) {
  const TemporaryFolder folder;
  const auto note = [&](const std::string& name, const std::string& text) {
    return TableNote(folder.Write(name, text));
  };
  EXPECT_EQ(note("f.csv", "time,z\n0,1\n"), "");
  EXPECT_EQ(note("f.csv", "time;z\n0;0,1\n"), "cells stand between ';', commas in numbers are taken for decimal marks");
  const std::string trc =
      "PathFileType\t4\t(X/Y/Z)\ta,b.trc\nDataRate\n100\t100\nFrame#\tTime\tleft, upper\n\tX1\tY1\tZ1\n\n";
  EXPECT_EQ(note("f.trc", trc + "1\t0.00\t1.5\t2\t3\n"), "");
  EXPECT_EQ(note("f.trc", trc + "1\t0,00\t1,5\t2\t3\n"), "commas in numbers are taken for decimal marks");
  EXPECT_EQ(TableNote(folder.File("absent.trc")), "");
}

}  // namespace
}  // namespace clothid::table_note_test
