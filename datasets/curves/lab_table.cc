#include "datasets/curves/lab_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/csv_row.h"
#include "sim/base/error.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr double kLargestReading = 1e9;  // m, N or N/m: beyond it a number is none of a machine

constexpr double kStandardGravity = 9.80665;  // m/s^2

constexpr double kDegree = 0.017453292519943295;  // rad

// A number in this unit times `factor` is one in N, N/m, m, 1 or rad.
struct LabUnit {
  LabQuantity quantity = LabQuantity::kForce;
  double factor = 1.0;
};

const std::vector<std::string_view> kWidthNames = {"width", "specimen width"};
const std::vector<std::string_view> kGaugeNames = {"gauge length", "gauge", "specimen length"};

std::optional<LabUnit> FindLabUnit(std::string_view name) {
  static const std::map<std::string, LabUnit, std::less<>> units = {
      {"cN", {LabQuantity::kForce, 1e-2}},
      {"gf", {LabQuantity::kForce, 1e-3 * kStandardGravity}},
      {"kgf", {LabQuantity::kForce, kStandardGravity}},
      {"N/m", {LabQuantity::kForcePerWidth, 1.0}},
      {"N/cm", {LabQuantity::kForcePerWidth, 1e2}},
      {"N/mm", {LabQuantity::kForcePerWidth, 1e3}},
      {"%", {LabQuantity::kStrain, 1e-2}},
      {"1", {LabQuantity::kStrain, 1.0}},
      {"-", {LabQuantity::kStrain, 1.0}},
      {"mm/mm", {LabQuantity::kStrain, 1.0}},
      {"m/m", {LabQuantity::kStrain, 1.0}},
      {"deg", {LabQuantity::kAngle, kDegree}},
      {"degree", {LabQuantity::kAngle, kDegree}},
      {"degrees", {LabQuantity::kAngle, kDegree}},
      {"\u00b0", {LabQuantity::kAngle, kDegree}},
      {"rad", {LabQuantity::kAngle, 1.0}}};
  if (const auto found = units.find(name); found != units.end()) return found->second;
  const std::optional<Unit> unit = FindUnit(name);
  if (unit && unit->quantity == Quantity::kForce) return LabUnit{LabQuantity::kForce, 1.0 / unit->per_si};
  if (unit && unit->quantity == Quantity::kLength) return LabUnit{LabQuantity::kLength, 1.0 / unit->per_si};
  return std::nullopt;
}

// "Force [N]" is the name "force" with the unit "N".
struct NamedCell {
  std::string name;  // in small letters
  std::string unit;  // empty: none
};

NamedCell SplitName(std::string_view cell) {
  NamedCell result;
  cell = Trimmed(cell);
  const std::size_t open = cell.find_last_of("[(");
  if (open != std::string_view::npos && open > 0 && (cell.back() == ']' || cell.back() == ')')) {
    result.unit = std::string(Trimmed(cell.substr(open + 1, cell.size() - open - 2)));
    cell = Trimmed(cell.substr(0, open));
  }
  while (!cell.empty() && cell.back() == ':') cell = Trimmed(cell.substr(0, cell.size() - 1));
  result.name = std::string(cell);
  for (char& c : result.name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c;
  return result;
}

// The brackets of a row of units, "[mm]", go.
std::string UnitOfCell(std::string_view cell) {
  cell = Trimmed(cell);
  const bool has_brackets =
      cell.size() > 2 && ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')'));
  return std::string(has_brackets ? Trimmed(cell.substr(1, cell.size() - 2)) : cell);
}

// How well `name` is one of `names`, 0 the best: its place, the plain one before one with words before it.
std::optional<std::size_t> Rank(const std::string& name, const std::vector<std::string_view>& names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i]) return 2 * i;
    const std::size_t size = names[i].size();
    if (name.size() > size + 1 && name[name.size() - size - 1] == ' ' &&
        name.compare(name.size() - size, size, names[i]) == 0) {
      return 2 * i + 1;
    }
  }
  return std::nullopt;
}

// As SeparatorOf, but of lines with decimal commas, too: "Width;95,92".
char SeparatorOfCurve(std::string_view line) {
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ';' && !is_quoted) return ';';
  }
  return SeparatorOf(line);
}

struct FoundColumn {
  std::size_t column = 0;
  std::string title;  // as it stands in the file
  std::string unit;   // empty: not told
  LabUnit scale;
};

class LabTableReader {
 public:
  LabTableReader(const std::string& path, const std::vector<LabForm>& forms)
      : path_(path), forms_(forms), text_(ReadText(path, kMaxCurveBytes)), rest_(text_) {}

  LabTable Read() {
    table_.name = path_;
    FindHeader();
    TakeUnits();
    for (std::size_t i = 0; i < found_.size(); ++i) {
      SetScale(forms_[table_.form].columns[i], &found_[i]);
      table_.quantities.push_back(found_[i].scale.quantity);
      table_.columns.push_back("'" + Printable(found_[i].title) + "' in " + Printable(found_[i].unit));
    }
    ReadRows();
    return std::move(table_);
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const { FailOnLine(line_, message); }
  [[noreturn]] void FailOnLine(int line, const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line) + ": " + message);
  }

  // The next line with something in it, in cells_; false where there is none.
  bool TakeCells(bool is_above_rows) {
    while (const std::optional<std::string_view> line = TakeLine(&rest_)) {
      ++line_;
      if (Trimmed(*line).empty()) continue;
      if (is_above_rows) separator_ = SeparatorOfCurve(*line);
      if (!SplitCells(*line, separator_, &cells_)) Fail(kExpectedQuotes);
      if (std::any_of(cells_.begin(), cells_.end(), [](const std::string& cell) { return !Trimmed(cell).empty(); })) {
        return true;
      }
    }
    return false;
  }

  bool IsNumber(const std::string& cell) const {
    return CellNumbers(separator_).Parse(std::string(Trimmed(cell))).has_value();
  }

  // The best column of these names; nothing where there is none. Throws where two are as good.
  // Those that were found before are left out.
  std::optional<FoundColumn> FindColumn(const std::vector<std::string_view>& names) const {
    std::optional<FoundColumn> best;
    std::size_t best_rank = 0;
    bool is_twice = false;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const auto is_taken = [i](const FoundColumn& found) { return found.column == i; };
      if (std::any_of(found_.begin(), found_.end(), is_taken)) continue;
      const NamedCell cell = SplitName(cells_[i]);
      const std::optional<std::size_t> rank = Rank(cell.name, names);
      if (!rank || (best && *rank > best_rank)) continue;
      is_twice = best && *rank == best_rank;
      best = FoundColumn{i, cells_[i], cell.unit, {}};
      best_rank = *rank;
    }
    if (is_twice) Fail("column '" + Printable(best->title) + "': expected once in the header");
    return best;
  }

  void FindHeader() {
    while (TakeCells(true)) {
      const auto is_number = [&](const std::string& cell) { return IsNumber(cell); };
      if (cells_.size() > 1 && std::all_of(cells_.begin(), cells_.end(), is_number)) FailWithoutHeader();
      // A line about the test may have the name of a column: "Preload force";"0,5";"N".
      const bool has_numbers = std::any_of(cells_.begin(), cells_.end(), is_number);
      if (!has_numbers && TakeHeader()) return;
      TakeDimension(kWidthNames, &table_.width);
      TakeDimension(kGaugeNames, &table_.gauge_length);
    }
    const std::string expected = "expected a header with " + Wanted() + ", as in '" + forms_[0].example + "'";
    if (nearly_line_ > 0) FailOnLine(nearly_line_, expected + ", found '" + Printable(nearly_) + "'");
    FailOnData(path_, expected);
  }

  std::string Wanted() const {
    std::string wanted;
    for (const LabForm& form : forms_) {
      const std::string own = form.wanted;
      wanted += (wanted.empty() || own.empty() ? "" : "; or ") + own;
    }
    return wanted;
  }

  [[noreturn]] void FailWithoutHeader() const {
    const std::string found =
        nearly_line_ == 0 ? "" : "; line " + std::to_string(nearly_line_) + " has '" + Printable(nearly_) + "' alone";
    Fail("expected a header above the first row of numbers, with " + Wanted() + ", as in '" + forms_[0].example + "'" +
         found);
  }

  // Whether the line has all columns of a form.
  bool TakeHeader() {
    bool has_one = false;
    for (table_.form = 0; table_.form < forms_.size(); ++table_.form) {
      found_.clear();
      for (const LabColumn& column : forms_[table_.form].columns) {
        const std::optional<FoundColumn> found = FindColumn(column.names);
        if (found) found_.push_back(*found);
      }
      if (found_.size() == forms_[table_.form].columns.size()) {
        num_cells_ = cells_.size();
        if (num_cells_ == 1) separator_ = '\t';  // nothing stands between cells: a comma is a decimal mark
        while (num_cells_ > 1 && Trimmed(cells_[num_cells_ - 1]).empty()) --num_cells_;
        return true;
      }
      has_one = has_one || !found_.empty();
    }
    if (has_one && nearly_line_ == 0) {
      nearly_line_ = line_;
      for (const std::string& cell : cells_) nearly_ += (nearly_.empty() ? "" : ";") + cell;
    }
    return false;
  }

  // "Width";"95,92";"mm" or "Width [mm]";"95,92".
  void TakeDimension(const std::vector<std::string_view>& names, std::optional<double>* dimension) const {
    const NamedCell key = SplitName(cells_[0]);
    if (std::find(names.begin(), names.end(), key.name) == names.end()) return;
    const std::string number = cells_.size() > 1 ? std::string(Trimmed(cells_[1])) : "";
    const std::optional<double> value = CellNumbers(separator_).Parse(number);
    const std::string source = "'" + Printable(Trimmed(cells_[0])) + "': ";
    if (!value || !(*value > 0.0 && *value <= kLargestReading))
      Fail(source + "expected a number > 0, found '" + Printable(number) + "'");
    const std::string name = key.unit.empty() && cells_.size() > 2 ? UnitOfCell(cells_[2]) : key.unit;
    const std::optional<LabUnit> unit = FindLabUnit(name);
    if (!unit || unit->quantity != LabQuantity::kLength) {
      Fail(source + "expected a unit, mm, cm or m, found '" + Printable(name) + "'");
    }
    *dimension = *value * unit->factor;
  }

  // A row below the header without a number in any of the columns.
  void TakeUnits() {
    const std::string_view rest = rest_;
    header_line_ = units_line_ = line_;
    if (TakeCells(false) && HasUnits()) {
      units_line_ = line_;
      for (FoundColumn& column : found_) {
        const std::string unit = UnitOfCell(cells_[column.column]);
        if (!unit.empty()) column.unit = unit;
      }
      return;
    }
    rest_ = rest;
    line_ = header_line_;
  }

  bool HasUnits() const {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (found_[i].column >= cells_.size()) return false;
      const std::string& cell = cells_[found_[i].column];
      const std::vector<LabQuantity>& quantities = forms_[table_.form].columns[i].quantities;
      const bool may_be_one = std::count(quantities.begin(), quantities.end(), LabQuantity::kStrain) > 0;
      if (IsNumber(cell) && !(may_be_one && UnitOfCell(cell) == "1")) return false;
    }
    return true;
  }

  void SetScale(const LabColumn& wanted, FoundColumn* column) const {
    const std::optional<LabUnit> unit = FindLabUnit(column->unit);
    if (unit && std::count(wanted.quantities.begin(), wanted.quantities.end(), unit->quantity) > 0) {
      column->scale = *unit;
      return;
    }
    const std::string source = "column '" + Printable(column->title) + "': ";
    if (column->unit.empty()) {
      FailOnLine(header_line_,
                 source + "expected a unit in brackets or in a row below, " + wanted.units + ", found none");
    }
    FailOnLine(units_line_, source + "expected the unit " + wanted.units + ", found '" + Printable(column->unit) + "'");
  }

  void ReadRows() {
    CellNumbers numbers(separator_);
    std::vector<double> values;
    while (TakeCells(false)) {
      while (cells_.size() > num_cells_ && Trimmed(cells_.back()).empty()) cells_.pop_back();
      if (cells_.size() != num_cells_) {
        Fail("expected " + std::to_string(num_cells_) + " cells as in the header, found " +
             std::to_string(cells_.size()) +
             (separator_ == ',' && cells_.size() > num_cells_ ? "; a decimal comma needs ';' or tabs between cells"
                                                              : ""));
      }
      for (const FoundColumn& column : found_) values.push_back(Number(column, &numbers));
      table_.lines.push_back(line_);
    }
    if (values.empty()) FailOnLine(units_line_, "expected rows of numbers below the header");
    const auto num_columns = static_cast<Eigen::Index>(found_.size());
    table_.values = Eigen::Map<const Eigen::MatrixXd>(values.data(), num_columns,
                                                      static_cast<Eigen::Index>(values.size()) / num_columns)
                        .transpose();
  }

  double Number(const FoundColumn& column, CellNumbers* numbers) const {
    const std::string cell(Trimmed(cells_[column.column]));
    const std::optional<double> value = numbers->Parse(cell);
    if (!value || !(std::abs(*value * column.scale.factor) <= kLargestReading)) {
      Fail("column '" + Printable(column.title) + "': expected a " + (value ? "smaller" : "finite") +
           " number, found '" + Printable(cell) + "'" + numbers->LikelyCause(cell));
    }
    return *value * column.scale.factor;
  }

  const std::string path_;
  const std::vector<LabForm>& forms_;
  const std::string text_;
  std::string_view rest_;
  int line_ = 0, header_line_ = 0, units_line_ = 0;
  char separator_ = ',';
  std::size_t num_cells_ = 0;  // of the header
  int nearly_line_ = 0;        // the first line with some of the columns; 0: none
  std::string nearly_;         // what stands in it
  std::vector<std::string> cells_;
  std::vector<FoundColumn> found_;  // in the order of the form's columns
  LabTable table_;
};

}  // namespace

LabTable ReadLabTable(const std::string& path, const std::vector<LabForm>& forms) {
  return LabTableReader(path, forms).Read();
}

}  // namespace clothid
