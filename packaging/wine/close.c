/* Starts a program, tells it after SECONDS that its window is closed, and says how and when it ended:
   close SECONDS PROGRAM [ARGUMENT...]. Wine's own window tells nothing when it is closed, so this does what Windows does
   then: it starts a thread at CtrlRoutine in the program. */
#include <windows.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int count, char **arguments)
{
    STARTUPINFOA start = { .cb = sizeof start };
    PROCESS_INFORMATION made;
    LPTHREAD_START_ROUTINE routine = (LPTHREAD_START_ROUTINE)(void *)GetProcAddress(GetModuleHandleA("kernelbase"), "CtrlRoutine");
    char line[4096] = "";
    DWORD code, told;
    if (count < 3 || !routine)
        return 2;
    for (int at = 2; at < count; at++) {
        strncat(line, arguments[at], sizeof line - strlen(line) - 1);
        strncat(line, " ", sizeof line - strlen(line) - 1);
    }
    if (!CreateProcessA(NULL, line, NULL, NULL, TRUE, 0, NULL, NULL, &start, &made))
        return printf("not started: error %lu\n", GetLastError()), 1;
    Sleep(1000 * (DWORD)atoi(arguments[1]));
    told = GetTickCount();
    if (!CreateRemoteThread(made.hProcess, NULL, 0, routine, (void *)CTRL_CLOSE_EVENT, 0, NULL))
        return printf("not told: error %lu\n", GetLastError()), 1;
    if (WaitForSingleObject(made.hProcess, 5000) != WAIT_OBJECT_0)
        return puts("not ended in the five seconds that Windows gives"), 1;
    GetExitCodeProcess(made.hProcess, &code);
    printf("ended with %lu after %lu ms\n", code, GetTickCount() - told);
    return 0;
}
