#include "LmdbCheck.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace isofront::voxels {

namespace {

using PageNumber = std::uint64_t;
constexpr PageNumber kNoPage = ~PageNumber{0};

/// Begins every page.
struct PageHeader {
    PageNumber number;
    std::uint16_t unused;
    std::uint16_t flags;
    std::uint16_t lower; ///< end of the offsets of nodes
    std::uint16_t upper; ///< begin of the nodes
};
static_assert(sizeof(PageHeader) == 16);
constexpr std::uint16_t kBranchPage = 0x01;
constexpr std::uint16_t kLeafPage = 0x02;
constexpr std::uint16_t kMetaPage = 0x08;

/// What there is to know of a table.
struct Table {
    std::uint32_t pageSize; ///< of the first table; of others unused
    std::uint16_t flags;
    std::uint16_t depth;
    std::uint64_t branchPages;
    std::uint64_t leafPages;
    std::uint64_t overflowPages;
    std::uint64_t entries;
    PageNumber root;
};
static_assert(sizeof(Table) == 48);

/// Follows the header of both first pages.
struct Meta {
    std::uint32_t magic;
    std::uint32_t version;
    std::uint64_t address;
    std::uint64_t mapSize;
    Table free;
    Table main;
    PageNumber lastPage;
    std::uint64_t transaction;
};
static_assert(sizeof(Meta) == 136);
constexpr std::uint32_t kMagic = 0xbeefc0de;
constexpr std::uint32_t kVersion = 1;
/// LMDB opens files where the fixed address of an earlier process was.
constexpr std::uint16_t kFixedAddress = 0x01;

/// Begins every node; the key follows, then the value or the number of its first page.
struct NodeHeader {
    std::uint16_t low;
    std::uint16_t high;
    std::uint16_t flags;
    std::uint16_t keySize;
};
static_assert(sizeof(NodeHeader) == 8);
constexpr std::uint16_t kBigValue = 0x01;
constexpr std::size_t kMostKeyBytes = 511;

constexpr std::size_t kLeastPageSize = 4096;
constexpr std::size_t kMostPageSize = 0x8000;
constexpr std::size_t kMostDepth = 32; ///< of LMDB's cursors
/// More than stores write; a bound for the memory of the check.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40U;

class File {
public:
    explicit File(const std::filesystem::path& path)
        : _descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC))
    {
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File()
    {
        if (_descriptor >= 0)
            ::close(_descriptor);
    }

    [[nodiscard]] bool isOpen() const { return _descriptor >= 0; }
    [[nodiscard]] std::uint64_t size() const
    {
        struct stat status {};
        return ::fstat(_descriptor, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
    }
    [[nodiscard]] bool read(std::uint64_t at, std::span<std::byte> bytes) const
    {
        while (!bytes.empty()) {
            const ::ssize_t count =
                ::pread(_descriptor, bytes.data(), bytes.size(), static_cast<::off_t>(at));
            if (count < 0 && errno == EINTR)
                continue;
            if (count <= 0)
                return false;
            at += static_cast<std::uint64_t>(count);
            bytes = bytes.subspan(static_cast<std::size_t>(count));
        }
        return true;
    }

private:
    int _descriptor;
};

template <typename T>
T valueAt(std::span<const std::byte> bytes, std::size_t at)
{
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

bool isMeta(const PageHeader& header, const Meta& meta)
{
    return (header.flags & kMetaPage) != 0 && meta.magic == kMagic && meta.version == kVersion;
}

/// The pages of a table from its root down.
class Tree {
public:
    Tree(const File& file, const Meta& meta, std::size_t pageSize)
        : _file(file), _table(meta.main), _pages(meta.lastPage + 1), _page(pageSize),
          _isTaken(static_cast<std::size_t>(_pages))
    {
        _isTaken[0] = _isTaken[1] = true;
    }

    [[nodiscard]] bool isInOrder()
    {
        if (_table.flags != 0)
            return false;
        if (_table.root == kNoPage)
            return _table.entries == 0 && _table.depth == 0;
        if (_table.depth < 1 || _table.depth > kMostDepth)
            return false;
        std::vector<PageNumber> level{_table.root};
        for (std::size_t depth = 1; depth <= _table.depth; ++depth) {
            std::vector<PageNumber> below;
            for (const PageNumber page : level)
                if (!readPage(page, depth == _table.depth, below))
                    return false;
            level = std::move(below);
        }
        return _entries == _table.entries;
    }

private:
    /// No page belongs to two.
    bool take(PageNumber first, std::uint64_t count)
    {
        if (first >= _pages || count > _pages - first)
            return false;
        for (std::uint64_t page = first; page < first + count; ++page) {
            if (_isTaken[static_cast<std::size_t>(page)])
                return false;
            _isTaken[static_cast<std::size_t>(page)] = true;
        }
        return true;
    }

    bool readPage(PageNumber number, bool isLeaf, std::vector<PageNumber>& below)
    {
        if (!take(number, 1) || !_file.read(number * _page.size(), _page))
            return false;
        const auto header = valueAt<PageHeader>(_page, 0);
        if (header.number != number || header.flags != (isLeaf ? kLeafPage : kBranchPage) ||
            header.lower < sizeof(PageHeader) || header.lower % 2 != 0 ||
            header.lower > header.upper || header.upper > _page.size())
            return false;
        const std::size_t nodes = (header.lower - sizeof(PageHeader)) / 2;
        if (nodes < (isLeaf ? 1U : 2U)) // LMDB asserts it
            return false;
        for (std::size_t i = 0; i < nodes; ++i) {
            const std::size_t at = valueAt<std::uint16_t>(_page, sizeof(PageHeader) + 2 * i);
            if (at < header.upper || at % 2 != 0 || at + sizeof(NodeHeader) > _page.size())
                return false;
            const auto node = valueAt<NodeHeader>(_page, at);
            const std::size_t rest = _page.size() - at - sizeof(NodeHeader);
            if (node.keySize > kMostKeyBytes || node.keySize > rest)
                return false;
            if (!isLeaf)
                below.push_back(
                    node.low | PageNumber{node.high} << 16U | PageNumber{node.flags} << 32U);
            else if (!takeValue(node, at + sizeof(NodeHeader) + node.keySize, rest - node.keySize))
                return false;
        }
        _entries += isLeaf ? nodes : 0;
        return true;
    }

    bool takeValue(const NodeHeader& node, std::size_t at, std::size_t room)
    {
        const std::size_t bytes = node.low | std::size_t{node.high} << 16U;
        if (node.keySize == 0 || (node.flags & ~kBigValue) != 0)
            return false;
        if ((node.flags & kBigValue) == 0)
            return bytes <= room;
        return sizeof(PageNumber) <= room &&
               take(
                   valueAt<PageNumber>(_page, at),
                   (sizeof(PageHeader) + bytes + _page.size() - 1) / _page.size());
    }

    const File& _file;
    const Table _table;
    std::uint64_t _pages;
    std::vector<std::byte> _page;
    std::vector<bool> _isTaken;
    std::uint64_t _entries = 0;
};

} // namespace

std::optional<core::Error> lmdbDamage(const std::filesystem::path& path)
{
    const auto damaged = [&](const std::string& what) {
        return core::Error{core::ErrorCode::badData, path.string() + ": " + what};
    };
    const File file(path);
    if (!file.isOpen())
        return core::Error{
            core::ErrorCode::inputOutput,
            path.string() + ": can't be opened: " + std::generic_category().message(errno)};
    const std::string remedy = "is damaged; voxelise again, or get it again";

    std::array<std::byte, sizeof(PageHeader) + sizeof(Meta)> begin{};
    if (!file.read(0, begin))
        return damaged("can't be opened: it is not a voxel model");
    std::array<Meta, 2> metas{valueAt<Meta>(begin, sizeof(PageHeader)), Meta{}};
    if (!isMeta(valueAt<PageHeader>(begin, 0), metas[0]))
        return damaged("can't be opened: it is not a voxel model");
    const std::size_t pageSize = metas[0].free.pageSize;
    if (pageSize < kLeastPageSize || pageSize > kMostPageSize || !std::has_single_bit(pageSize))
        return damaged(remedy);
    const std::uint64_t size = file.size();
    const bool hasSecond = file.read(pageSize, begin);
    metas[1] = valueAt<Meta>(begin, sizeof(PageHeader));
    if (!hasSecond || !isMeta(valueAt<PageHeader>(begin, 0), metas[1]))
        return damaged(remedy);
    for (const Meta& meta : metas) {
        if (meta.free.pageSize != pageSize || (meta.free.flags & kFixedAddress) != 0)
            return damaged(remedy);
        if (meta.lastPage >= size / pageSize)
            return damaged(
                "is cut short, or damaged: it has " + std::to_string(size) + " bytes for " +
                std::to_string(meta.lastPage) + " pages of " + std::to_string(pageSize) +
                "; get it again");
        if (meta.lastPage < 1 || meta.lastPage >= kMostBytes / pageSize)
            return damaged(remedy);
    }
    // as LMDB chooses
    const Meta& newer = metas[metas[0].transaction < metas[1].transaction ? 1 : 0];
    if (!Tree(file, newer, pageSize).isInOrder())
        return damaged(remedy);
    return std::nullopt;
}

} // namespace isofront::voxels
