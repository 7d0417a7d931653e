#include "NewFolder.h"

#include <unistd.h>

#include <string>
#include <system_error>
#include <utility>

namespace isofront::tiles {

namespace fs = std::filesystem;

core::Result<NewFolder> NewFolder::create(const fs::path& path)
{
    const auto failure = [&](const std::string& why) {
        return core::failure(core::ErrorCode::inputOutput, path.string() + ": " + why);
    };
    // "out/" names the same as "out"
    const fs::path target = path.has_filename() ? path : path.parent_path();
    std::error_code error;
    if (fs::exists(fs::symlink_status(target, error))) {
        if (!fs::is_directory(target, error) || fs::is_symlink(target, error))
            return failure("is there and no folder; choose another name");
        if (!fs::is_empty(target, error) || error)
            return failure("the folder isn't empty; choose a new or an empty one");
    }
    for (int attempt = 0; attempt < 1000; ++attempt) {
        const fs::path temporary = target.parent_path() / ("." + target.filename().string() + "." +
                                                           std::to_string(::getpid()) + "-" +
                                                           std::to_string(attempt) + ".part");
        if (fs::create_directory(temporary, error))
            return NewFolder(target, temporary);
        if (error)
            return failure("no folder can be made there (" + error.message() + ")");
    }
    return failure("there are too many unfinished folders beside it; remove those in .part");
}

NewFolder::NewFolder(NewFolder&& other) noexcept
    : _target(std::move(other._target)), _temporary(std::exchange(other._temporary, {}))
{
}

NewFolder::~NewFolder()
{
    std::error_code ignored;
    if (!_temporary.empty())
        fs::remove_all(_temporary, ignored);
}

core::Result<void> NewFolder::commit()
{
    std::error_code error;
    fs::rename(_temporary, _target, error); // takes the place of an empty folder
    if (error)
        return core::failure(
            core::ErrorCode::inputOutput,
            _target.string() + ": the finished folder can't be given its name (" + error.message() +
                ")");
    _temporary.clear();
    return {};
}

} // namespace isofront::tiles
