/* Reads from a file and holds it open as spreadsheets do: others may read it, and neither write, rename nor delete it. hold FILE SECONDS */
#include <windows.h>
#include <stdio.h>
#include <stdlib.h>

int main(int count, char **arguments)
{
    HANDLE file;
    DWORD taken;
    char byte;
    if (count != 3)
        return 2;
    file = CreateFileA(arguments[1], GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_WRITE, NULL, OPEN_EXISTING, 0, NULL);
    if (file == INVALID_HANDLE_VALUE || !ReadFile(file, &byte, 1, &taken, NULL) || taken != 1)
        return 1;
    puts("held");
    fflush(stdout);
    Sleep(1000 * (DWORD)atoi(arguments[2]));
    return 0;
}
