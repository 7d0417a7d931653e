#include "isofront/bench/Table.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace isofront::bench {

namespace {

std::string quoted(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos)
        return text;
    std::string result = "\"";
    for (const char c : text)
        result += c == '"' ? std::string("\"\"") : std::string(1, c);
    return result + '"';
}

/// The shortest digits that read back as the same number.
std::string exactly(double value)
{
    if (!std::isfinite(value))
        return {};
    std::array<char, 40> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

} // namespace

std::size_t Table::column(const std::string& columnName) const
{
    const auto found = std::ranges::find(columns, columnName, &Column::name);
    ISOFRONT_ASSERT(found != columns.end(), name + " has no column '" + columnName + "'");
    return static_cast<std::size_t>(found - columns.begin());
}

double Table::number(std::size_t row, const std::string& columnName) const
{
    const Cell& cell = rows.at(row).at(column(columnName));
    if (const auto* value = std::get_if<double>(&cell))
        return *value;
    if (const auto* value = std::get_if<std::int64_t>(&cell))
        return static_cast<double>(*value);
    return std::numeric_limits<double>::quiet_NaN();
}

std::string Table::word(std::size_t row, const std::string& columnName) const
{
    const Cell& cell = rows.at(row).at(column(columnName));
    const auto* value = std::get_if<std::string>(&cell);
    return value != nullptr ? *value : textOf(cell);
}

void Table::add(std::vector<Cell> row)
{
    ISOFRONT_ASSERT(
        row.size() == columns.size(),
        name + ": a row of " + std::to_string(row.size()) + " cells for " +
            std::to_string(columns.size()) + " columns");
    rows.push_back(std::move(row));
}

std::string csvOf(const Table& table)
{
    std::string csv;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
        const Column& column = table.columns[i];
        csv += (i == 0 ? "" : ",") +
               quoted(column.unit.empty() ? column.name : column.name + " [" + column.unit + "]");
    }
    csv += "\r\n";
    for (const auto& row : table.rows) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            csv += i == 0 ? "" : ",";
            if (const auto* word = std::get_if<std::string>(&row[i]))
                csv += quoted(*word);
            else if (const auto* value = std::get_if<double>(&row[i]))
                csv += exactly(*value);
            else
                csv += std::to_string(std::get<std::int64_t>(row[i]));
        }
        csv += "\r\n";
    }
    return csv;
}

std::string textOf(const Cell& cell)
{
    if (const auto* word = std::get_if<std::string>(&cell))
        return *word;
    if (const auto* count = std::get_if<std::int64_t>(&cell)) {
        std::string digits = std::to_string(*count);
        const std::size_t first = *count < 0 ? 1 : 0;
        for (std::size_t i = digits.size(); i > first + 3;)
            digits.insert(i -= 3, ",");
        return digits;
    }
    const double value = std::get<double>(cell);
    if (!std::isfinite(value))
        return "-";
    std::array<char, 32> text{};
    (void)std::snprintf(text.data(), text.size(), "%.4g", value);
    return text.data();
}

} // namespace isofront::bench
