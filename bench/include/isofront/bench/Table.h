#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace isofront::bench {

/// One column of a table.
struct Column {
    std::string name;    ///< as a program reads it: lower case, words joined by '_'
    std::string unit;    ///< "ms", "px", "steps"; empty for counts and words
    std::string meaning; ///< in a few words, for people
};

/// A word, a measured number or a count. A number that isn't finite was not measured.
using Cell = std::variant<std::string, double, std::int64_t>;

/// A picture of a table: one column over another, a curve for each word of a third.
struct Plot {
    std::string name;   ///< of its file, within the suite
    std::string title;  ///< what one sees
    std::string x, y;   ///< columns
    std::string series; ///< column whose words tell curves apart; empty for one curve
    /// Column and word: only rows with that word are shown. Empty for all.
    std::string whereColumn, whereWord;
    bool isLogarithmicX = false;
    bool isLogarithmicY = false;
    std::vector<double> guides; ///< slopes, see charts::ScatterChart
};

/// What a suite measured: a rectangle of cells under named columns.
struct Table {
    std::string name;
    std::string title;
    std::vector<Column> columns;
    std::vector<std::vector<Cell>> rows; ///< each as long as `columns`
    std::vector<Plot> plots;

    /// Index of a column; it must be there (asserted).
    [[nodiscard]] std::size_t column(const std::string& columnName) const;
    /// The number in a cell; NaN for a word.
    [[nodiscard]] double number(std::size_t row, const std::string& columnName) const;
    [[nodiscard]] std::string word(std::size_t row, const std::string& columnName) const;
    /// Adds a row as long as the columns (asserted).
    void add(std::vector<Cell> row);
};

/// A count as a cell.
template <typename Integer>
Cell count(Integer value)
{
    return static_cast<std::int64_t>(value);
}

/// The table by RFC 4180: names with units in the first line, numbers with all their digits, an
/// empty field for what was not measured.
std::string csvOf(const Table& table);

/// A cell as people read it: four digits, thousands apart; "-" for what was not measured.
std::string textOf(const Cell& cell);

} // namespace isofront::bench
