#include "datasets/curves/curve_table.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::curve_table_test {
namespace {

class CurveTableTest : public testing::Test {
 protected:
  CurveTable Read(const std::string& text) const { return ReadCurveTable(folder_.Write("c.csv", text)); }

  void ExpectRefused(const std::string& text, const char* place, const char* expected) const {
    ExpectError([&] { Read(text); }, ErrorKind::kBadData, {place, expected});
  }

  TemporaryFolder folder_;
};

TEST_F(CurveTableTest, ReadsWhatAMachineExports) {
  const CurveTable table = Read(
      "\"Specimen\";\"no 1, along \"\"y\"\"\"\r\n\"Preload force\";\"0,5\";\"N\"\r\n\"Width\";\"95,92\";\"mm\"\r\n"
      "\"Gauge length\";\"4,5\";\"cm\"\r\n\r\n\"Time\";\"Extension\";\"Force\"\r\n\"s\";\"mm\";\"N\"\r\n"
      "0,0000;0,0012;0,0000\r\n0,1333;-0,0002;1,5\r\n\r\n0,2;2;3;\r\n");
  EXPECT_EQ(table.elongations, Eigen::Vector3d(0.0012 * 1e-3, -0.0002 * 1e-3, 2.0 * 1e-3));
  EXPECT_EQ(table.forces, Eigen::Vector3d(0.0, 1.5, 3.0));
  EXPECT_FALSE(table.is_strain || table.is_per_width);
  EXPECT_NEAR(table.width.value(), 0.09592, 1e-15);
  EXPECT_NEAR(table.gauge_length.value(), 0.045, 1e-15);
  EXPECT_EQ(table.columns, "'Extension' in mm and 'Force' in N");
}

TEST_F(CurveTableTest, ReadsEveryUnit) {
  const auto force = [&](const std::string& unit) { return Read("Strain [%],Load (" + unit + ")\n50,2\n"); };
  for (const auto& [unit, newtons] :
       {std::pair("N", 2.0), {"mN", 2e-3}, {"kN", 2e3}, {"cN", 2e-2}, {"gf", 2e-3 * 9.80665}, {"kgf", 2.0 * 9.80665}}) {
    EXPECT_DOUBLE_EQ(force(unit).forces[0], newtons) << unit;
    EXPECT_FALSE(force(unit).is_per_width) << unit;
  }
  for (const auto& [unit, tension] : {std::pair("N/m", 2.0), {"N/cm", 200.0}, {"N/mm", 2000.0}}) {
    EXPECT_DOUBLE_EQ(force(unit).forces[0], tension) << unit;
    EXPECT_TRUE(force(unit).is_per_width) << unit;
  }
  const auto elongation = [&](const std::string& unit) { return Read("Displacement,Force\n" + unit + ",N\n5,2\n"); };
  for (const auto& [unit, metres] : {std::pair("mm", 5e-3), {"cm", 5e-2}, {"m", 5.0}}) {
    EXPECT_DOUBLE_EQ(elongation(unit).elongations[0], metres) << unit;
    EXPECT_FALSE(elongation(unit).is_strain) << unit;
  }
  for (const auto& [unit, strain] : {std::pair("%", 5e-2), {"1", 5.0}, {"mm/mm", 5.0}, {"-", 5.0}, {"[%]", 5e-2}}) {
    EXPECT_DOUBLE_EQ(elongation(unit).elongations[0], strain) << unit;
    EXPECT_TRUE(elongation(unit).is_strain) << unit;
  }
}

TEST_F(CurveTableTest, ChoosesAmongColumns) {
  EXPECT_EQ(Read("Time\tTensile strain\tTensile Extension\tSTANDARD FORCE\ts\ns\t%\tmm\tN\t\n0\t1\t2\t3\t4\n").columns,
            "'Tensile Extension' in mm and 'STANDARD FORCE' in N");
  EXPECT_EQ(Read("Corrected extension [mm],Extension [mm],Force [N]\n1,2,3\n").elongations[0], 2e-3);
  EXPECT_EQ(Read("Force rate,Force,Dehnung\nN/s,N,%\n1,2,3\n").forces[0], 2.0);
}

TEST_F(CurveTableTest, ReadsTheWidth) {
  CurveTable table = Read("Width;95;mm\nExtension [mm];Force [N];Width [mm]\n0;0;50\n1;2;49\n");
  EXPECT_EQ(table.widths, Eigen::Vector2d(0.05, 0.049));
  EXPECT_EQ(table.elongations[1], 1e-3);
  EXPECT_EQ(table.forces[1], 2.0);
  EXPECT_FALSE(table.is_width_strain);
  EXPECT_DOUBLE_EQ(table.width.value(), 0.095);
  EXPECT_EQ(table.columns, "'Width [mm]' in mm, 'Extension [mm]' in mm and 'Force [N]' in N");
  table = Read("Transverse strain [%],Tensile strain [%],Force [N]\n0,0,0\n-1,2,3\n");
  EXPECT_EQ(table.widths, Eigen::Vector2d(0.0, -0.01));
  EXPECT_TRUE(table.is_width_strain && table.is_strain);
  EXPECT_EQ(table.elongations[1], 0.02);
  EXPECT_EQ(Read("Width [mm],Extension [mm],Force [N]\n50,0,0\n50,2,3\n").widths.size(), 0) << "of the specimen";
  EXPECT_EQ(Read("Extension [mm],Force [N]\n0,0\n2,3\n").widths.size(), 0);
  ExpectRefused("Width [N],Extension [mm],Force [N]\n1,2,3\n", "c.csv:1: ", "column 'Width [N]': expected the unit mm");
}

TEST_F(CurveTableTest, RefusesBadTables) {
  const std::string header = "Time;Extension;Force\ns;mm;N\n";
  ExpectRefused("", "c.csv: ", "expected a header with columns of force and of extension, displacement or strain");
  ExpectRefused("Specimen;1\nTime;Extension\n", "c.csv:2: ", "found 'Time;Extension'");
  ExpectRefused("Time [s];Force [N]\n0;1\n", "c.csv:2: ", "line 1 has 'Time [s];Force [N]' alone");
  ExpectRefused("Specimen;1\n0,1;2,5\n", "c.csv:2: ", "expected a header above the first row of numbers");
  ExpectRefused("Time;Extension [mm];Force\n0;1;2\n", "c.csv:1: column 'Force'",
                "expected a unit in brackets or in a row");
  ExpectRefused("Extension;Force [N]\n1;2\n", "c.csv:1: column 'Extension'", "mm, cm, m, % or 1, found none");
  ExpectRefused("Extension;Force\nmm;\n1;2\n", "c.csv:1: column 'Force'", "found none");
  ExpectRefused("Extension;Force\nmm;lbf\n1;2\n", "c.csv:2: column 'Force'", "expected the unit N, mN, kN");
  ExpectRefused("Extension;Force\nN;mm\n1;2\n", "c.csv:2: column 'Extension'", "found 'N'");
  ExpectRefused("Extension [in];Force [N]\n1;2\n", "c.csv:1: column 'Extension [in]'", "found 'in'");
  ExpectRefused("Force;Force;Strain\nN;N;%\n1;2;3\n", "c.csv:1: column 'Force'", "expected once in the header");
  ExpectRefused(header, "c.csv:2: ", "expected rows of numbers");
  ExpectRefused(header + "0;1;2\n0;1\n", "c.csv:4: ", "expected 3 cells as in the header, found 2");
  ExpectRefused(header + "0;1;2\nbreak;;\n", "c.csv:4: column 'Extension'", "expected a finite number, found ''");
  ExpectRefused(header + "0;1;2\n1;1;2 N\n", "c.csv:4: column 'Force'", "found '2 N'");
  ExpectRefused(header + "0;1;inf\n", "c.csv:3: column 'Force'", "found 'inf'");
  ExpectRefused(header + "0;1;1e12\n", "c.csv:3: column 'Force'", "expected a smaller number, found '1e12'");
  ExpectRefused(header + "0;1,5;2\n1;1.5;2\n", "c.csv:4: column 'Extension'", "have ',' as their decimal mark");
  ExpectRefused(header + "0;1.234,5;2\n", "c.csv:3: column 'Extension'", "no marks between thousands");
  ExpectRefused("Extension [mm],Force [N]\n1,5,2,5\n", "c.csv:2: ", "a decimal comma needs ';' or tabs");
  ExpectRefused(header + "0;\"1;2\n", "c.csv:3: ", "quoted cells");
  ExpectRefused("Width;wide;mm\n" + header + "0;1;2\n", "c.csv:1: 'Width'", "expected a number > 0, found 'wide'");
  ExpectRefused("Gauge length;45\n" + header + "0;1;2\n", "c.csv:1: 'Gauge length'", "expected a unit, mm, cm or m");
  ExpectError([&] { ReadCurveTable(folder_.File("none.csv")); }, ErrorKind::kIo, {"none.csv"});
}

}  // namespace
}  // namespace clothid::curve_table_test
