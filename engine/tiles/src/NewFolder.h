#pragma once

#include <isofront/core/Result.h>

#include <filesystem>

namespace isofront::tiles {

/// A folder that appears under its name only when it is whole: filled beside it under a temporary
/// name, and renamed by `commit`. Destroyed without a commit it leaves nothing behind.
class NewFolder {
public:
    /// @return inputOutput if `path` is there and no empty folder, or can't be written beside
    static core::Result<NewFolder> create(const std::filesystem::path& path);

    NewFolder(NewFolder&& other) noexcept;
    NewFolder& operator=(NewFolder&&) = delete;
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;
    ~NewFolder();

    core::Result<void> commit();
    /// Where to write.
    [[nodiscard]] const std::filesystem::path& path() const { return _temporary; }

private:
    NewFolder(std::filesystem::path target, std::filesystem::path temporary)
        : _target(std::move(target)), _temporary(std::move(temporary))
    {
    }

    std::filesystem::path _target;
    std::filesystem::path _temporary; ///< empty after the commit
};

} // namespace isofront::tiles
